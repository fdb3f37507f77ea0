"""A robot process without a robot, for tests: it is where it is told to be, and goes wrong where a test wants it to.

``python perfect_arm.py ROBOT JOINTS OPENING [WHAT STEP]``: its type, where its arm stands [rad] and its fingers are [m], as JSON; what
goes wrong, and at which step, 0 for the answer to "hello".
"""

import json
import sys
import time

robot, joints, opening, *rest = sys.argv[1:]
what, when = (rest[0], int(rest[1])) if rest else ("", -1)
state = {"joints": json.loads(joints), "opening": float(opening), "wrench": [0.0] * 6}
hello = {"protocol": 1, "robot": robot, "actions": "joints", "rate": 20}
WRONG = {
    "garbage": "MOTOR OK",
    "bytes": "\udcff",
    "nan": json.dumps(state | {"opening": float("nan")}),
    "huge": json.dumps(state | {"opening": 1e999}),
    "few": json.dumps(state | {"joints": [0.0]}),
    "list": "[]",
    "long": "0" * (1 << 22),
    "old": json.dumps(hello | state | {"protocol": 0}),
    "other": json.dumps(hello | state | {"robot": "another"}),
    "slow": json.dumps(hello | state | {"rate": 0}),
    "loose": json.dumps(hello | state | {"tolerance": [0, 1]}),
    "numb": json.dumps(hello | {k: v for k, v in state.items() if k != "wrench"}),
    "stop": json.dumps(state | {"stop": "the emergency stop is pressed"}),
}
for number, line in enumerate(sys.stdin):
    ask = json.loads(line)
    if ask["ask"] == "end":
        break
    if number == when and what == "dies":
        sys.exit("the fieldbus is gone")
    if number == when and what == "hangs":
        time.sleep(60)
    if number == when and what in WRONG:
        sys.stdout.reconfigure(errors="surrogateescape")
        print(WRONG[what], flush=True)
        continue
    if ask["ask"] == "step" and not (what == "stuck" and number >= when):
        state |= {"joints": ask["joints"], "opening": ask["opening"]}
    print(json.dumps((hello if ask["ask"] == "hello" else {}) | state), flush=True)
