"""URScript as others write it: script files, labels, structs, handles, arrays; and valid programs made by a grammar."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import RobotMount, World
from cramlite.plugin import UserError
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulator.execute import execute
from cramlite_plugins.simulator.simulator import MujocoSimulator
from cramlite_plugins.ur_controller.urscript.builtins import PURE
from cramlite_plugins.ur_controller.urscript.interpreter import Machine, Stopped, examine, load
from cramlite_plugins.ur_controller.urscript.parser import parse


def sync() -> Iterator[None]:
    yield


LIBRARY = {**PURE, "sync": sync}


def run(text: str) -> dict[str, Any]:
    machine = Machine(load(text, LIBRARY), LIBRARY)
    for _ in range(100):
        if machine.finished:
            break
        machine.cycle()
    return machine.variables


@pytest.mark.parametrize(
    "text",
    [
        "x = 3",
        "x = 1\ndef f(a, b=1):\n  return a + b\nend\nx = f(2)\n",
        "def f(a):\n  return a\nend\n# between\ndef g():\n  global x = f(3)\nend\ng()\n",
        "def p():\n  $ 1 \"Robot Program\"\n  $ 2 \"x≔3\" \"noBreak\"\n  x = 3\nend",
        '$ 3 "says "so""\nx = 3\n',
        "\ufeffdef p():\r\n\tx = 3\r\nend\r\n",
        "def p():\r  x = 3 # old ends of lines\rend\r",
        "  def p():\n    global x = 3\n  end\np()",
        "sec p():\n  x = 3\nend",
        "def p():\n  x = 3\nend\np()\n# after",
        "thread t():\n  global x = 3\n  return None\nend\nh = run t()\njoin h\n",
        "if (! False): x = 3 end",
        "if not(True): x = 1 elif(True): x = 3 else: x = 2 end",
        "x = -\n3 x = # a comment\n-x",
    ],
)
def test_all_of_a_text_runs(text: str) -> None:
    assert run(text)["x"] == 3


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("struct(a = 1, end = 2).end", 2),
        ("struct(a = 1, b = [1, 2])[1][0]", 1),
        ("[[1, 2], [3, 4]][1, 0]", 3),
        ("[1, 2] + [3, 4.5]", [4, 6.5]),
        ("[4, 9] - 1", [3, 8]),
        ("2 * [1, 2] * [3, 4]", [6, 16]),
        ("-[1, -2]", [-1, 2]),
        ("[5, 6] % 4", [1, 2]),
        ("[[1, 2], [3, 4]] * [1, 1]", [3, 7]),
        ("[1, 1] * [[1, 2], [3, 4]]", [4, 6]),
        ("[[1, 2]] * [[3], [4]]", [[11]]),
        ("[[1, 2], [3, 4]] * 2 / 4", [[0.5, 1.0], [1.5, 2.0]]),
        ("transpose([[1, 2, 3]])", [[1], [2], [3]]),
        ("inv([[2, 0], [0, 4]]) * [[2, 0], [0, 4]]", [[1.0, 0.0], [0.0, 1.0]]),
        ("inv(p[1, 0, 0, 0, 0, 0])[0]", -1.0),
        ("size([[1, 2, 3], [4, 5, 6]])", [2, 3]),
        ("normalize([3, 4])", [0.6, 0.8]),
        ("get_list_length([1, 2])", 2),
        ("binary_list_to_integer(integer_to_binary_list(-5))", -5),
        ("binary_list_to_integer([True, False, True])", 5),
        ("rpy2rotvec([0, 0, 1.5])", [0.0, 0.0, 1.5]),
        ("rotvec2rpy(rpy2rotvec([0.3, -0.7, 1.2]))", [0.3, -0.7, 1.2]),
        ('"Hello" + ", " + "World!"', "Hello, World!"),
        ('str_sub("Hello", 1, 3)', "ell"),
        ('str_sub("Hello", 3)', "lo"),
        ('str_find("Hello", "l", 3) + str_find("Hello", "x")', 2),
        ('str_at("Hello", 4)', "o"),
        ('str_len("abc") + size("ab")', 5),
        ('str_empty("")', True),
        ("None == None", True),
        ("struct(a = 1) == struct(a = 1)", True),
    ],
)
def test_expressions(expression: str, value: Any) -> None:
    result = run(f"x = {expression}")["x"]
    assert result == (value if isinstance(value, str) or "[[" in str(value) else pytest.approx(value))


def test_fields_are_set_and_structs_are_values() -> None:
    variables = run("s = struct(n = 1, v = [1, 2])\nt = s\nt.n = 5\nt.v[0] = 7\nt[1][1] = 8\nk = s.v\nk[0] = 9")
    assert variables["s"] == {"n": 1, "v": [1, 2]} and variables["t"] == {"n": 5, "v": [7, 8]}


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("s = struct(a = 1)\ns.b = 2", "line 2: a struct with the fields a has no field 'b'"),
        ("x = 3\ny = x.a", "line 2: only structs have fields"),
        ("s = struct(a = 1)\nx = s[1]", "index 1"),
        ("x = [1, 2] + [1]", "lists of one length, not of 2 and 1"),
        ("x = [[1, 2]] * [[1, 2]]", "as many columns on its left as rows on its right, not 2 and 1"),
        ("x = [[1, 2], [3]] * [1, 1]", "rows of one length"),
        ("x = p[0, 0, 0, 0, 0, 0] * 2", "pose_trans"),
        ('x = "a" + 1', "to_str"),
        ("x = [1, True] * 2", "needs numbers, not True"),
        ("x = inv([[1, 2], [2, 4]])", "has an inverse"),
        ("x = inv([[1, 2]])", "square"),
        ("x = normalize([0, 0])", "not all 0"),
        ("x = binary_list_to_integer([1, 0])", "truth values"),
        ('x = str_at("ab", 2)', "2 is no whole number in 0 .. 1"),
        ("x = str_len(5)", "needs a string"),
        ("s = struct(a = 1)\nwhile True:\n  s = struct(a = s, b = s)\nend", "deep|more than"),
        ("s = struct(a = [1])\nwhile True:\n  s.a = [s, s, s]\nend", "deep|more than"),
        ("x = [2147483647] * [[2]]", "32 bits"),
    ],
)
def test_what_goes_wrong_stops_with_its_line(body: str, reason: str) -> None:
    with pytest.raises(Stopped, match=reason):
        run(body)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x = 1\nend", "line 2: this 'end' closes nothing"),
        ("def f():\n  x = 1\n", "line 3: 'def' of line 1 has no 'end'"),
        ("def f(): end\ndef g(): end", "line 1: nothing would run: 'f', 'g' are only defined"),
        ("  def p():\n  end", "column 0"),
        ("# nothing at all", "the end of the text"),
        ('x = 1 $ 2 "label"', "line 1: a label .* needs a line of its own"),
        ("$ Robot Program\nx = 1", "line 1: a label is a number and a text"),
        ("x = {{SPEED}}", "line 1: .*a template"),
        ("x\u00a0= 1", "NO-BREAK SPACE"),
        ("x = struct(1)", "a name of its own for each field"),
        ("x = struct(a = 1, a = 2)", "a name of its own for each field"),
        ("x = [1][]", "an index is missing"),
        ("x.a() = 1", "only a variable, an element of a list or a field of a struct"),
        ("x = 1\ny = x.3", "found '.3'"),
        ("x = 1.\ny = x. + 2", "a name after '.'"),
        ("x = movej([1])\nwhile True\nend", "line 3: expected ':' after the condition"),
        ("y = x", "line 1: 'x' is assigned nowhere here"),
        ("rpc = rpc_factory(\"xmlrpc\", \"http://127.0.0.1\")\nrpc.go.on(1)", "line 1: .* UR's function 'rpc_factory'; 1 more place"),
        ("x = [1]\nx.append(2)", "line 2: '.append..' is a call on a handle"),
        ("def f():\n  g()\nend\ndef g():\n  powerdown()\nend\nf()", "line 5: .* UR's function 'powerdown'"),
        ("x = v_joint_default", "UR's variable 'v_joint_default'"),
    ],
)
def test_what_cannot_run_is_refused_with_its_line(text: str, reason: str) -> None:
    with pytest.raises(UserError, match=reason):
        load(text, LIBRARY)


def test_what_is_never_called_may_need_what_there_is_not() -> None:
    text = 'def unused():\n  rpc.go(powerdown(), outside)\n  run elsewhere()\nend\nrpc = None\nx = 1'
    assert run(text)["x"] == 1
    assert {lack.line for lack in examine(text, LIBRARY)[1]} == {2, 3}


def test_a_program_of_polyscope_runs_without_what_it_does_not_call() -> None:
    text = """def exported():
  set_standard_analog_input_domain(0, 1)
  set_tool_voltage(24)
  set_input_actions_to_default()
  set_safety_mode_transition_hardness(1)
  $ 1 "Robot Program"
  global home = get_actual_joint_positions()
  $ 2 "MoveJ" "noBreak"
  movej(home, a=1.4, v=1.05)
  textmsg("there: ", struct(n = 1))
end
"""
    world = World((), (RobotMount("arm", "ur5e"),))
    done = execute(text, world, {"ur5e": UR5E}, mount="arm", time_limit=5.0)
    assert done.outcome == "finished" and done.messages[-1].text == "there: struct(n = 1)"
    off = execute(text.replace("24", "17"), world, {"ur5e": UR5E}, mount="arm", time_limit=5.0)
    assert off.outcome == "error" and "line 3: set_tool_voltage's voltage is one of 0, 12, 24" in off.reason


@pytest.mark.parametrize(
    ("text", "refused"),
    [
        ("def p():\n  normalise([1])\nend", True),
        ("Norm([1])", True),
        ("def p():\n  def grip(): end\n  gripp()\nend", True),
        ("def open_1(): end\nopen_2()", False),
        ("def open_a(): end\nopen_b()", False),
        ("get_list_lengths_of_all([1])", False),
        ("motion_version_set(2)", False),
        ("a_library_of_others(2)", False),
    ],
)
def test_only_a_misspelt_function_is_wrong_where_others_may_be_elsewhere(text: str, refused: bool) -> None:
    if refused:
        with pytest.raises(UserError, match=r"there is no function .* did you mean"):
            examine(text, LIBRARY)
    else:
        assert len(examine(text, LIBRARY)[1]) == 1


def test_every_parameter_of_the_manual_may_be_given() -> None:
    text = """
set_tcp(p[0, 0, 0.15, 0, 0, 0], "gripper")
set_target_payload(0.5, [0, 0, 0.05], [0, 0, 0, 0, 0, 0], 0.1)
here = get_forward_kin()
global same = get_inverse_kin_has_solution(here, tcp = get_tcp_offset())
global away = get_inverse_kin_has_solution(here, tcp = p[0, 0, 5, 0, 0, 0])
socket_open("127.0.0.1", 63352, "g")
textmsg(same, away)
x = socket_read_string("g", prefix = "(", timeout = 1)
"""
    done = execute(text, World((), (RobotMount("arm", "ur5e"),)), {"ur5e": UR5E}, mount="arm", time_limit=5.0)
    assert done.messages[-1].text == "TrueFalse"
    assert done.outcome == "error" and "line 9: socket_read_string: prefix and suffix are not modelled" in done.reason


def test_what_cannot_run_is_listed_once_with_all_its_lines() -> None:
    found = list(MujocoSimulator().inspect("h = rpc_factory(\"xmlrpc\", \"a\")\nh.go()\nh.go()\nx = 1 + True\n"))
    assert [line for line, _ in found] == [2, 4]
    assert found[0][1].endswith("no values with methods; also in line 3")


def test_a_blend_that_is_not_modelled_is_told_and_none_that_is() -> None:
    at = "p[0.4, 0, 0.3, 3.14, 0, 0]"
    told = (f"movel({at}, 1.2, 0.25, 0, 0.02)", f"movel({at}, r=0.02)", f"movec({at}, {at}, r=b)")
    lines = (*told, f"movel({at}, r=0)", f"movep({at}, r=0.1)")
    found = list(MujocoSimulator().inspect("b = 0.1\n" + "\n".join(lines) + "\n"))
    assert [(line, said.split(":")[0]) for line, said in found if "blend radius" in said] == [(2, "movel"), (3, "movel"), (4, "movec")]


# Valid programs, made by a grammar

NAMES = st.sampled_from(["a", "b2", "p", "_c", "Point_1_p", "endless", "structure"])
FIELDS = st.sampled_from(["x", "end", "run", "p", "RobotEnabled"])
ATOMS = st.one_of(
    st.sampled_from(["1", "0x1F", "2.5", ".5", "1.", "1e-3", "True", "False", "None", '"text # $ 1"', "'t'", "p[1,2,3,4,5,6]", "[]"]),
    NAMES,
)


def _wider(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    operators = st.sampled_from(["+", "-", "*", "/", "%", "==", "!=", "<", ">", "<=", ">=", " and ", " or ", " xor ", "\n+ # so\n"])
    return st.one_of(
        st.builds("({}{}{})".format, inner, operators, inner),
        st.builds("({}({}))".format, st.sampled_from(["-", "not ", "!", "+"]), inner),
        st.builds("[{}, {}]".format, inner, inner),
        st.builds("{}[{}]".format, NAMES.filter(lambda n: n != "p"), inner),
        st.builds("{}[{}, {}]".format, NAMES.filter(lambda n: n != "p"), inner, inner),
        st.builds("{}.{}".format, NAMES, FIELDS),
        st.builds("{}.{}({})".format, NAMES, FIELDS, inner),
        st.builds("struct({}={})".format, FIELDS, inner),
        st.builds("f({}, k = {})".format, inner, inner),
    )


EXPRESSIONS = st.deferred(lambda: st.recursive(ATOMS, _wider, max_leaves=6))
SIMPLE = st.one_of(
    st.builds("{}{} = {}".format, st.sampled_from(["", "local ", "global "]), NAMES, EXPRESSIONS),
    st.builds("{}.{} = {}".format, NAMES, FIELDS, EXPRESSIONS),
    st.builds("a[{}] = {}".format, EXPRESSIONS, EXPRESSIONS),
    st.builds("f({})".format, EXPRESSIONS),
    st.builds("a.{}({})".format, FIELDS, EXPRESSIONS),
    st.builds('$ {} "{}"'.format, st.integers(0, 999), st.sampled_from(["Robot Program", 'a "b"', "v≔1", "# no comment"])),
    st.builds("# {}".format, st.text("é\t $\"'ab")),
    st.sampled_from(["halt", "sync()", "return None", "return\n", "enter_critical", "exit_critical", "h = run t()", "kill h", "join h"]),
)


def _nested(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    body = st.lists(inner, max_size=3).map("\n\t".join)
    return st.one_of(
        st.builds("if {}:\n{}\nend".format, EXPRESSIONS, body),
        st.builds("if({}):\n{}\nelif {}:\n{}\nelse:\n{}\nend".format, EXPRESSIONS, body, EXPRESSIONS, body, body),
        st.builds("while {}:\n{}\nbreak\nend".format, EXPRESSIONS, body),
        st.builds("def f(a, k={}):\n{}\nend".format, EXPRESSIONS, body),
        st.builds("thread t():\n{}\nend".format, body),
        st.builds("sec s():\n{}\nend".format, body),
    )


PROGRAMS = st.lists(st.recursive(SIMPLE, _nested, max_leaves=8), min_size=1, max_size=5).map(lambda lines: "\n".join([*lines, "x = 1"]))


@examples(300)
@given(PROGRAMS, st.sampled_from(["\n", "\r\n", "\r"]))
def test_every_program_of_the_grammar_is_accepted(text: str, end_of_line: str) -> None:
    whole = parse(text.replace("\n", end_of_line))
    assert whole == parse(text), "the ends of lines change nothing, line numbers included"
    inside = parse(f"def p():\n{text}\nend\n")
    assert inside.name == "p" and len(inside.body) == (len(whole.body) if not whole.name else 1)


@examples(150)
@given(PROGRAMS, st.data())
def test_what_is_made_of_it_is_refused_by_nothing_but_user_errors(text: str, data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(text)))
    piece = data.draw(st.sampled_from(["", "end", ".", "[", "]", "(", "$", '"', ":", "struct(", "!", "\x00", "run "]))
    for changed in (text[:at] + piece + text[at:], text[:at] + text[at + 1 :]):
        assert refusal(changed) in ("", "URScript, line")


def refusal(text: str) -> str:
    """How the refusal of a text begins; empty if there is none. Any other error escapes."""
    try:
        list(MujocoSimulator().inspect(text))
    except UserError as error:
        return " ".join(str(error).split()[:2])
    return ""
