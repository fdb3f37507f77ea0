"""The parts of every RAPID program: the header with its preconditions, and the routines that tasks call.

Instructions and their arguments: ABB, "Technical reference manual RAPID Instructions, Functions and Data types" (RobotWare 6 and
7) and "Application manual Force control Standard", written from memory of them: nothing here ran on a controller.
Readings of rapidchecker are about syntax alone.
"""

from __future__ import annotations

from cramlite.model import Program, Robot

LABEL = "UNVERIFIED: RAPID cannot be run here. No instruction below was carried out by a controller, real or virtual."

ROUTINES = """
  ! ---- routines ----
  VAR errnum errStep := -1;
  VAR bool bForce := FALSE;

  ! A step has failed: come to rest, say why, and let the caller judge.
  PROC Fail(string reason)
    StopMove;
    ClearPath;
    StartMove;
    ReleaseForce;
    TPWrite "cramlite: " + reason;
    RAISE errStep;
  ENDPROC

  PROC CheckStart()
    VAR jointtarget jHere;
    jHere := CJointT();
    IF Abs(jHere.robax.rax_1 - jStart.robax.rax_1) > START_TOLERANCE OR
      Abs(jHere.robax.rax_2 - jStart.robax.rax_2) > START_TOLERANCE OR
      Abs(jHere.robax.rax_3 - jStart.robax.rax_3) > START_TOLERANCE OR
      Abs(jHere.robax.rax_4 - jStart.robax.rax_4) > START_TOLERANCE OR
      Abs(jHere.robax.rax_5 - jStart.robax.rax_5) > START_TOLERANCE OR
      Abs(jHere.robax.rax_6 - jStart.robax.rax_6) > START_TOLERANCE THEN
      Fail "the arm is not at the start posture jStart";
    ENDIF
  ENDPROC

  ! Fingers to a position, 0 open .. 255 closed. giGripObject: 0 moving, 1 and 2 stopped by an object, 3 at the position.
  PROC Grip(num position, num speed, num force, string expect, num timeout, string step)
    VAR bool bLate := FALSE;
    SetGO goGripSpeed, speed;
    SetGO goGripForce, force;
    SetGO goGripPosition, position;
    PulseDO \\PLength:=0.1, doGripGo;
    WaitUntil giGripEcho = position AND giGripObject > 0 \\MaxTime:=timeout \\TimeFlag:=bLate;
    IF bLate THEN
      Fail step + ": the gripper still moved";
    ELSEIF expect = "object" AND giGripObject = 3 THEN
      Fail step + ": no object between the fingers";
    ELSEIF expect = "none" AND giGripObject <> 3 THEN
      Fail step + ": an object stopped the fingers";
    ENDIF
  ENDPROC

  ! Straight on until the sensor reports a force along the way above aoContactForce [N].
  PROC MoveToContact(num x, num y, num z, num force, speeddata speed, bool needed, string step)
    VAR robtarget pEnd;
    VAR robtarget pFound;
    SetAO aoContactForce, force;
    pEnd := Offs(CRobT(\\Tool:=tGripper \\WObj:=wBase), x, y, z);
    SearchL \\Stop, diContact, pFound, pEnd, speed, tGripper \\WObj:=wBase;
    TPWrite step + ": contact";
  ERROR
    IF ERRNO = ERR_WHLSEARCH THEN
      IF needed THEN
        Fail step + ": no contact";
      ENDIF
      TRYNEXT;
    ENDIF
    RAISE;
  ENDPROC
"""

FORCE = """
  ! ---- force control: needs the RobotWare option and a calibrated sensor ----
  PROC TakeForce(orient frame)
    FCAct tGripper \\WObj:=wBase \\ForceFrameOri:=frame;
    bForce := TRUE;
  ENDPROC

  PROC ReleaseForce()
    IF bForce THEN
      FCDeact;
    ENDIF
    bForce := FALSE;
  ENDPROC

  PROC Tare(loaddata carried)
    WaitTime \\InPos, 0.3;
    FCCalib carried;
  ENDPROC

  ! Push with forces along x, y and z of a frame until the tool has come a way along z.
  PROC PushAlong(orient frame, num fx, num fy, num fz, pos way, num limit, num timeout, string step)
    VAR robtarget pFrom;
    VAR clock cTime;
    pFrom := CRobT(\\Tool:=tGripper \\WObj:=wBase);
    TakeForce frame;
    FCRefForce \\Fx:=fx \\Fy:=fy \\Fz:=fz;
    FCRefStart;
    ClkReset cTime;
    ClkStart cTime;
    WHILE Gone(pFrom, way) < VectMagn(way) DO
      Watch cTime, limit, timeout, step;
    ENDWHILE
    FCRefStop;
    ReleaseForce;
  ENDPROC

  ! Press along z of a frame on a spiral across it until the tool gives way, or a rim holds it.
  PROC SearchSpiral(orient frame, num force, num pitch, num radius, num speed, pos way, num limit, num timeout, string step)
    VAR robtarget pFrom;
    VAR clock cTime;
    VAR num nAcross := 0;
    pFrom := CRobT(\\Tool:=tGripper \\WObj:=wBase);
    TakeForce frame;
    FCRefForce \\Fz:=force;
    FCRefSpiral FCPLANE_XY, speed / radius / 6.283, radius, radius / pitch;
    FCRefStart;
    ClkReset cTime;
    ClkStart cTime;
    WHILE Gone(pFrom, way) < VectMagn(way) AND nAcross < 2 * force DO
      Watch cTime, limit, timeout, step;
      nAcross := Across(frame);
    ENDWHILE
    FCRefStop;
    ReleaseForce;
  ENDPROC

  PROC Watch(VAR clock cTime, num limit, num timeout, string step)
    IF Measured() > limit THEN
      Fail step + ": force above its limit";
    ELSEIF ClkRead(cTime) > timeout THEN
      Fail step + ": not done in time";
    ENDIF
    WaitTime 0.01;
  ENDPROC

  FUNC num Measured()
    VAR fcforcevector f;
    f := FCGetForce(\\Tool:=tGripper);
    RETURN Sqrt(f.xforce * f.xforce + f.yforce * f.yforce + f.zforce * f.zforce);
  ENDFUNC

  ! The force across z of a frame of the base [N].
  FUNC num Across(orient frame)
    VAR fcforcevector f;
    VAR pose turn := [[0, 0, 0], [1, 0, 0, 0]];
    VAR pos inFrame;
    turn.rot := frame;
    f := FCGetForce(\\WObj:=wBase);
    inFrame := PoseVect(PoseInv(turn), [f.xforce, f.yforce, f.zforce]);
    RETURN Sqrt(inFrame.x * inFrame.x + inFrame.y * inFrame.y);
  ENDFUNC

  ! How far the tool has come from a place along a way [mm].
  FUNC num Gone(robtarget pFrom, pos way)
    VAR robtarget pHere;
    pHere := CRobT(\\Tool:=tGripper \\WObj:=wBase);
    RETURN DotProd(pHere.trans - pFrom.trans, way) / VectMagn(way);
  ENDFUNC
"""

NO_FORCE = """
  PROC ReleaseForce()
    bForce := FALSE;
  ENDPROC

  PROC Tare(loaddata carried)
    WaitTime \\InPos, 0.3;
    PulseDO \\PLength:=0.1, doZeroSensor;
  ENDPROC
"""


def header(program: Program, robot: Robot, forces: bool) -> list[str]:
    """Write the preconditions of the program, as comments."""
    control = "and Force Control (FCAct, FCRefForce, FCRefSpiral, FCGetForce)" if forces else "; no Force Control is used"
    lines = [
        "Generated by cramlite from a typed program, which ran in simulation. This text did not:",
        LABEL,
        "PRECONDITIONS",
        f"  robot: {robot.type} '{program.robot}', RobotWare 6 or 7 {control}",
        f"  gripper: {robot.gripper.type} on a field bus: signals goGripPosition, goGripSpeed, goGripForce (0 .. 255),",
        "    doGripGo, giGripEcho (requested position), giGripObject (0 moving, 1 and 2 object, 3 at the position)",
        f"  force sensor: {robot.sensor}; diContact is set while the force against the motion is above aoContactForce [N]"
        + ("" if forces else "; doZeroSensor tares it"),
        f"  a protective limit of {program.force_limit:.0f} N on the TCP force, by the safety controller or the sensor",
        "  start posture jStart, checked to START_TOLERANCE degrees",
        "Poses that were bound when this was planned (base frame, mm); move one of these things, and plan anew:",
    ]
    for s in program.snapshots:
        place = ", ".join(f"{1000 * v:.1f}" for v in s.pose.position)
        lines.append(f"  {s.thing}: [{place}], {s.source}, {s.age:.1f} s old")
    return lines if program.snapshots else lines[:-1]
