% The phases and predicates of cramlite's rules, stated over the facts of a loaded timeline, as KnowRob's rule base
% and the published rules of Alt et al. (KR 2023) state them. The facts (tests/timeline_translation.py writes them):
%
%   action(Action, Start, End, anonymous|labelled)      labelled(Start, End, Class, Object)    padding(Seconds)
%   state(Class, Id, Start, End)  role(Id, Role, Thing)  state_type(Class)    second(Class, Second, Id, Start, End)
%   entity(Thing)  type(Thing, Class)  part_of(Part, Whole)  effector(Thing)  located(Thing, Since)
%   sub(Class, Superclass)  restriction(Class, Property, Filler)  dof(Thing, Number)
%   fixed(Thing, Pose)  pose(Time, Thing, Pose)          Pose = p(X,Y,Z, W,I,J,K) in the world, at boundaries
%   box(Thing, b(X,Y,Z), b(X,Y,Z))                       lower and upper corner in its frame
%   measured(Start, End, Quantity, Thing, Value)         excursion, turn, upright: extremes between samples
%   opening(Start, End, Least, Largest)                  shares of the widest opening, and spread(Start, End, Metres)
%
% A phase is ph(From, To); an instant has From = To.

phase(pre, A, ph(S, S)) :- action(A, S, _, _).
phase(run, A, ph(S, E)) :- action(A, S, E, _).
phase(post, A, ph(T, T)) :- action(A, _, E, K), terminal(K, E, T).

terminal(anonymous, E, E).
terminal(labelled, E, T) :-
    padding(P), Last is E + P,
    (   labelled(S, F, _, _), S >= E, S < Last, \+ ( labelled(S2, _, _, _), S2 >= E, S2 < S )
    ->  T is min(Last, (S + F) / 2)
    ;   T = Last ).

% Classes: the closure of the subclass axioms.
subclass(C, C).
subclass(C, D) :- sub(C, B), subclass(B, D).
is_class(C, D) :- C == D, !.
is_class(C, D) :- once(subclass(C, D)).

isa(_, X, C) :- instance(X, C).
instance(X, C) :- nonvar(X), !, once(( type(X, T), is_class(T, C) )).
instance(X, C) :- entity(X), once(( type(X, T), is_class(T, C) )).

within(X, X).
within(X, Z) :- part_of(X, Y), within(Y, Z).

has(_, X, C) :- instance(Y, C), within(Y, X).
has(_, X, C) :- type(X, T), subclass(T, A), restriction(A, 'soma:hasFeature', F), is_class(F, C).

part(_, X, Y) :- part_of(Y, Z), within(Z, X).
effector(_, X) :- effector(X).
thing(_, X) :- is_thing(X).
is_thing(X) :- entity(X), \+ part_of(X, _), \+ effector(X), \+ instance(X, 'soma:PhysicalEffector').

% States that hold all through a phase, or at some time of it. candidate/6 is one of the two below.
spanning(P, Class, Id) :- spanning_states(P, Class, Ids), member(Id, Ids).
spanning_states(ph(S, E), Class, Ids) :-
    findall(Id, ( state_class(Class, T), candidate(T, S, S, Id, From, To), From =< S, ( S =:= E -> S < To ; To >= E ) ),
            Ids).
overlapping(ph(S, E), Class, Id) :- S =:= E, spanning(ph(S, E), Class, Id).
overlapping(ph(S, E), Class, Id) :-
    S < E, state_class(Class, T), candidate(T, S, E, Id, From, To), From < E, To > S.
state_class(Class, T) :- state_type(T), is_class(T, Class).

lifted(A, B, X, Y) :- within(A, X), \+ within(B, X), within(B, Y), \+ within(A, Y).

grasps(P, G, X) :- spanning(P, 'cram:GraspState', I), role(I, gripper, G), role(I, object, X).
contains(P, C, X) :- spanning(P, 'soma:ContainmentState', I), role(I, container, C), role(I, content, X).
supports(P, X, Y) :-
    spanning(P, 'soma:SupportState', I), role(I, supporter, A), role(I, supportee, B), lifted(A, B, X, Y).
touches(P, X, Y) :- spanning(P, 'soma:ContactState', I), contact(I, X, Y).
contact(I, X, Y) :- role(I, a, A), role(I, b, B), ( lifted(A, B, X, Y) ; lifted(B, A, X, Y) ).

chain(_, X) :- entity(X), effector(G), within(X, G).
chain(P, X) :- effector(G), grasps(P, G, H), entity(X), within(X, H).

collides(P, X, Y) :-
    overlapping(P, 'soma:ContactState', I), contact(I, X, Y), once(chain(P, X)), \+ chain(P, Y).

on_container(P, X) :-
    ( touches(P, C, X) ; supports(P, C, X) ), C \== X, instance(C, 'soma:DesignedContainer').

constrained_dof(P, X, Y, V) :-
    findall(D, ( ( A = X ; touches(P, A, Y), within(A, X) ; supports(P, A, Y), within(A, X) ), degrees(A, D) ), Ds),
    max_list(Ds, V).
degrees(A, D) :- dof(A, D), !.
degrees(A, D) :-
    findall(F, ( type(A, T), subclass(T, C), restriction(C, 'cram:constrainedDof', F) ), Fs),
    ( Fs == [] -> D = 1.0 ; max_list(Fs, D) ).

labelled(ph(S, E), Task, X) :- labelled(S, E, T, X), subclass(T, Task).

% Motion: measured between samples.
arm_moves(ph(S, E)) :- effector(G), measured(S, E, excursion, G, D), D > 0.001.
gripper_moves(ph(S, E)) :- spread(S, E, D), D > 0.020.
gripper_closed(ph(S, E)) :- opening(S, E, _, High), High < 0.25.
gripper_open(ph(S, E)) :- opening(S, E, Low, _), Low > 0.75.
moves(ph(S, E), X) :-
    measured(S, E, excursion, X, D), \+ part_of(X, _),
    ( D > 0.005 -> true ; measured(S, E, turn, X, A), A > 0.1 ).
tilts(ph(S, E), X) :- measured(S, E, upright, X, C), C < 0.8660254037844387.
driven(ph(S, E), X) :-
    effector(G), displaced(S, E, X, DX, DY, DZ), displaced(S, E, G, HX, HY, HZ),
    Along is sqrt(DX * DX + DY * DY + DZ * DZ), Along > 0.005,
    HX * DX + HY * DY + HZ * DZ > 0.5 * sqrt(HX * HX + HY * HY + HZ * HZ) * Along.
displaced(S, E, X, DX, DY, DZ) :-
    pose(S, X, p(AX, AY, AZ, _, _, _, _)), pose(E, X, p(BX, BY, BZ, _, _, _, _)),
    DX is BX - AX, DY is BY - AY, DZ is BZ - AZ.

% Places: arithmetic over poses and boxes.
located_at(_, X, P) :- fixed(X, P), !.
located_at(T, X, P) :- pose(T, X, P).

seen_from(T, X, Y, PX, PY, PZ) :-                  % origin of Y in the frame of X
    located_at(T, X, p(OX, OY, OZ, W, I, J, K)), located_at(T, Y, p(QX, QY, QZ, _, _, _, _)),
    DX is QX - OX, DY is QY - OY, DZ is QZ - OZ,
    PX is (1 - 2 * (J * J + K * K)) * DX + 2 * (I * J + W * K) * DY + 2 * (I * K - W * J) * DZ,
    PY is 2 * (I * J - W * K) * DX + (1 - 2 * (I * I + K * K)) * DY + 2 * (J * K + W * I) * DZ,
    PZ is 2 * (I * K + W * J) * DX + 2 * (J * K - W * I) * DY + (1 - 2 * (I * I + J * J)) * DZ.

gap(T, X, Y, D) :-                                 % from the origin of Y to the box of X
    seen_from(T, X, Y, PX, PY, PZ),
    ( box(X, b(LX, LY, LZ), b(UX, UY, UZ)) -> true ; LX = 0, LY = 0, LZ = 0, UX = 0, UY = 0, UZ = 0 ),
    GX is max(max(LX - PX, PX - UX), 0), GY is max(max(LY - PY, PY - UY), 0), GZ is max(max(LZ - PZ, PZ - UZ), 0),
    D is sqrt(GX * GX + GY * GY + GZ * GZ).

approaches(ph(S, E), X) :-
    effector(G), any_thing(X), gap(S, X, G, D0), gap(E, X, G, D1), D0 - D1 > 0.01.
within_reach(ph(_, E), X) :- effector(G), any_thing(X), gap(E, X, G, D), D < 0.15.
near(ph(_, E), X, Y) :- any_thing(Y), any_thing(X), X \== Y, gap(E, Y, X, D), D < 0.15.
in_or_above(ph(_, E), X, Y) :-
    any_thing(Y), box(Y, b(LX, LY, LZ), b(UX, UY, _)), any_thing(X), X \== Y, seen_from(E, Y, X, PX, PY, PZ),
    PX >= LX, PX =< UX, PY >= LY, PY =< UY, PZ >= LZ.
between_fingers(ph(_, E), X) :-
    tip(1, L), tip(2, R), any_thing(X), box(X, b(LX, LY, LZ), b(UX, UY, UZ)),
    seen_from(E, X, L, AX, AY, AZ), seen_from(E, X, R, BX, BY, BZ),
    slab(AX, BX, LX, UX, 0, 1, S1, T1), slab(AY, BY, LY, UY, S1, T1, S2, T2), slab(AZ, BZ, LZ, UZ, S2, T2, S, T), S =< T.
slab(A, B, L, U, S, T, S, T) :- A =:= B, !, A >= L, A =< U.
slab(A, B, L, U, S, T, Enter, Leave) :-
    N is (L - A) / (B - A), F is (U - A) / (B - A), Enter is max(S, min(N, F)), Leave is min(T, max(N, F)).
any_thing(X) :- nonvar(X), !.
any_thing(X) :- is_thing(X).

pose_known(ph(_, E), X) :- located(X, Since), Since =< E.

in_view(ph(_, E), X) :-
    any_thing(X), instance(C, 'cram:Camera'), C \== X, seen_from(E, C, X, PX, PY, PZ),
    atan2(sqrt(PX * PX + PY * PY), PZ) < 0.5235987755982988.

% Joints: joint(Start, End, Thing, Least, Largest, First, Last), as shares of the joint's range.
joint_rises(ph(S, E), X) :- joint(S, E, X, _, _, First, Last), Last - First > 0.05.
joint_falls(ph(S, E), X) :- joint(S, E, X, _, _, First, Last), First - Last > 0.05.
joint_closed(ph(S, E), X) :- joint(S, E, X, _, High, _, _), High =< 0.05.
joint_open(ph(S, E), X) :- joint(S, E, X, Low, _, _, _), Low >= 0.20.
joint_wide(ph(S, E), X) :- joint(S, E, X, Low, _, _, _), Low >= 0.80.
parked(ph(S, E)) :- from_park(S, E, D), D < 0.05.
