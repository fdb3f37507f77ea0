"""Published data of the arms of Universal Robots other than UR5 and UR5e: the series CB3 and e-Series, and the larger arms that followed
them.

Lengths: Universal Robots, "DH parameters for calculations of kinematics and dynamics", which UniversalRobots/
Universal_Robots_Client_Library repeats. Masses, centres of mass, inertia, offsets, torques and speeds: UniversalRobots/
Universal_Robots_ROS2_Description, config/*/physical_parameters.yaml (commit 3426d67) and joint_limits.yaml; centres and inertia are
turned into Denavit-Hartenberg axes as the comments of those files say. Reach and payload: data sheets.

Not published, or not checked:
  - accelerations (the files: "not publicly available"): 5 rad/s2, as for the UR5e;
  - inertia of the UR3: the file's are of cylinders. The UR30's in the file are the UR16e's, digit for digit: here shoulder and
    wrist are the UR20's, which has the same masses there, and both links the UR20's, by mass and by length squared;
  - precision of the force sensors: data sheets, from memory, not checked; noise and drift are those of the UR5e;
  - the elbow turns +-360 deg in the data sheets of some; +-180 deg as in the maker's files, so that a posture has one name;
  - radii of feet and joints: ours, to 10 mm. Adapters between a wide flange (UR20, UR30: 80 mm) and the gripper are left out.

The UR7e is the UR5e and the UR12e the UR10e, renamed in 2025 (the client library says so). The UR8 Long, UR15 and UR18 are not here:
their lengths were found, limits and inertias were not looked up.
"""

from __future__ import annotations

from .universal_robots import UrArm

CB3, E_SERIES = "CB3", "e-Series"
UR10_CENTRES = (
    (0.021, 0.0, 0.027), (0.38, 0.0, 0.158), (0.24, 0.0, 0.068), (0.0, 0.007, 0.018), (0.0, 0.007, 0.018), (0.0, 0.0, -0.026),
)  # fmt: skip
UR10_INERTIA = (
    (0.03408, 0.03529, 0.02156, 0.00002, -0.00425, 0.00008),
    (0.02814, 0.77068, 0.76943, 0.00005, -0.01561, 0.00002),
    (0.01014, 0.30928, 0.30646, 0.00008, 0.00916, 0.0),
    (0.00296, 0.00222, 0.00258, -0.00001, 0.0, -0.00024),
    (0.00296, 0.00222, 0.00258, -0.00001, 0.0, -0.00024),
    (0.00040, 0.00041, 0.00034, 0.0, 0.0, 0.0),
)
UR20_SHOULDER = (0.08866, 0.07632, 0.08418, -0.00011, -0.00011, 0.00720)
UR20_WRIST = (
    (0.00555, 0.00537, 0.00402, -0.00001, -0.00002, 0.00036),
    (0.00586, 0.00578, 0.00427, -0.00001, -0.00002, -0.00037),
    (0.00092, 0.00091, 0.00117, 0.0, 0.0, 0.0),
)

UR3 = UrArm(
    type="ur3", controller=CB3, payload=3.0, reach=0.5, precision=None,
    lengths=(0.1519, -0.24365, -0.21325, 0.11235, 0.08535, 0.0819),
    offsets=(0.1198, 0.0275), radii=(0.064, 0.05, 0.042, 0.034),
    masses=(2.0, 3.42, 1.26, 0.8, 0.8, 0.35),
    centres=((0.0, -0.02, 0.0), (0.13, 0.0, 0.1157), (0.05, 0.0, 0.0238), (0.0, 0.0, 0.01), (0.0, 0.0, 0.01), (0.0, 0.0, -0.02)),
    inertia=(
        (0.0080932, 0.0056250, 0.0080932, 0.0, 0.0, 0.0),
        (0.0096188, 0.0217285, 0.0217285, 0.0, 0.0, 0.0),
        (0.0035438, 0.0065468, 0.0065468, 0.0, 0.0, 0.0),
        (0.0016106, 0.0022500, 0.0016106, 0.0, 0.0, 0.0),
        (0.0015722, 0.0022500, 0.0015722, 0.0, 0.0, 0.0),
        (0.0001363, 0.0001363, 0.0001792, 0.0, 0.0, 0.0),
    ),
    torques=(56.0, 28.0, 12.0), speeds=(180.0, 180.0, 360.0), home=(2.6695, -1.5596, 0.6561, -0.6672, -1.5708, 1.0987),
)  # fmt: skip
UR3E = UrArm(
    type="ur3e", controller=E_SERIES, payload=3.0, reach=0.5, precision=2.0,
    lengths=(0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
    offsets=(0.12, 0.027), radii=(0.064, 0.05, 0.042, 0.034),
    masses=(1.98, 3.4445, 1.437, 0.871, 0.805, 0.261),
    centres=UR3.centres,
    inertia=(
        (0.0027657, 0.0021501, 0.0025626, 0.0000096, -0.0000149, 0.0001873),
        (0.0042623, 0.0460284, 0.0448947, -0.0000409, -0.0014960, -0.0000129),
        (0.0010511, 0.0113396, 0.0110895, 0.0, -0.0000331, 0.0000022),
        (0.0008174, 0.0006844, 0.0005497, -0.0000005, 0.0000021, 0.0000617),
        (0.0006059, 0.0005837, 0.0003831, -0.0000006, -0.0000006, -0.0000271),
        (0.0001080, 0.0001086, 0.0001371, -0.0000001, -0.0000001, -0.0000002),
    ),
    torques=(56.0, 28.0, 12.0), speeds=(180.0, 180.0, 360.0), home=(2.5825, -1.6685, 0.8640, -0.7663, -1.5708, 1.0117),
)  # fmt: skip
UR10 = UrArm(
    type="ur10", controller=CB3, payload=10.0, reach=1.3, precision=None,
    lengths=(0.1273, -0.612, -0.5723, 0.163941, 0.1157, 0.0922),
    offsets=(0.220941, 0.049042), radii=(0.095, 0.075, 0.06, 0.05),
    masses=(7.1, 12.7, 4.27, 2.0, 2.0, 0.365), centres=UR10_CENTRES, inertia=UR10_INERTIA,
    torques=(330.0, 150.0, 56.0), speeds=(120.0, 180.0, 180.0), home=(2.8835, -1.6486, 1.3876, -1.3098, -1.5708, 1.3127),
)  # fmt: skip
UR10E = UrArm(
    type="ur10e", controller=E_SERIES, payload=12.5, reach=1.3, precision=5.0,
    lengths=(0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
    offsets=(0.1762, 0.0393), radii=(0.095, 0.075, 0.06, 0.05),
    masses=(7.369, 13.051, 3.989, 2.1, 1.98, 0.615), centres=UR10_CENTRES, inertia=UR10_INERTIA,
    torques=(330.0, 150.0, 56.0), speeds=(120.0, 180.0, 180.0), home=(2.8670, -1.6776, 1.5121, -1.4053, -1.5708, 1.2962),
)  # fmt: skip
UR16E = UrArm(
    type="ur16e", controller=E_SERIES, payload=16.0, reach=0.9, precision=5.0,
    lengths=(0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655),
    offsets=(0.176, 0.04), radii=(0.095, 0.075, 0.06, 0.05),
    masses=(7.369, 10.45, 4.321, 2.18, 2.033, 0.907),
    centres=(
        (0.0, -0.016, 0.03), (0.302, 0.0, 0.16), (0.194, 0.0, 0.065), (0.0, -0.009, 0.011), (0.0, 0.018, 0.012),
        (0.0, 0.0, -0.044),
    ),
    inertia=(
        (0.03351, 0.03374, 0.02100, 0.00002, -0.00001, 0.00374),
        (0.02796, 0.47558, 0.47635, -0.00010, -0.00720, 0.00003),
        (0.01091, 0.12060, 0.11714, 0.00006, 0.01012, 0.00001),
        (0.00609, 0.00245, 0.00579, -0.00001, 0.0, 0.00083),
        (0.00389, 0.00219, 0.00363, -0.00001, 0.0, -0.00045),
        (0.00117, 0.00118, 0.00084, 0.0, 0.0, 0.0),
    ),
    torques=(330.0, 150.0, 54.0), speeds=(120.0, 180.0, 180.0), home=(2.7392, -1.7139, 1.5981, -1.4549, -1.5708, 1.1684),
)  # fmt: skip
UR20 = UrArm(
    type="ur20", controller=E_SERIES, payload=20.0, reach=1.75, precision=5.0,
    lengths=(0.2363, -0.862, -0.7287, 0.201, 0.1593, 0.1543),
    offsets=(0.26, 0.043), radii=(0.1225, 0.095, 0.075, 0.06),
    masses=(16.343, 29.632, 7.879, 3.054, 3.126, 0.926),
    centres=(
        (0.0, -0.061, 0.0062), (0.5226, 0.0, 0.2098), (0.3234, 0.0, 0.0604), (0.0, -0.0026, 0.0393), (0.0, 0.0024, 0.0379),
        (0.0, 0.0, -0.0293),
    ),
    inertia=(
        UR20_SHOULDER,
        (0.14670, 4.66590, 4.63480, 0.00019, -0.05163, 0.00004),
        (0.02612, 0.75763, 0.75327, -0.00005, -0.02898, -0.00001),
        *UR20_WRIST,
    ),
    torques=(738.0, 433.0, 107.0), speeds=(120.0, 150.0, 210.0), home=(2.9070, -1.6243, 1.5741, -1.5207, -1.5708, 1.3362),
)  # fmt: skip
UR30 = UrArm(
    type="ur30", controller=E_SERIES, payload=30.0, reach=1.3, precision=5.0,
    lengths=(0.2363, -0.637, -0.5037, 0.201, 0.1593, 0.1543),
    offsets=(0.26, 0.043), radii=(0.1225, 0.095, 0.075, 0.06),
    masses=(16.343, 28.542, 7.156, 3.054, 3.126, 0.926),
    centres=(
        (-0.0001, -0.06, 0.0069), (0.3894, 0.0, 0.2103), (0.2257, 0.0, 0.0629), (0.0, -0.0048, 0.0353), (0.0, 0.0046, 0.0341),
        (0.0, 0.0, -0.0293),
    ),
    inertia=(
        UR20_SHOULDER,
        (0.14130, 2.45430, 2.43800, 0.00010, -0.03675, 0.00002),
        (0.02372, 0.32876, 0.32687, -0.00003, -0.01819, 0.0),
        *UR20_WRIST,
    ),
    torques=(730.0, 430.0, 100.0), speeds=(120.0, 150.0, 210.0), home=(2.8233, -1.6499, 1.5495, -1.4704, -1.5708, 1.2525),
)  # fmt: skip
ARMS = (UR3, UR3E, UR10, UR10E, UR16E, UR20, UR30)
