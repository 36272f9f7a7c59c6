"""Robots with two legs, written as MJCF."""

LEG = """
<body name="{side}_hip_yaw_link" pos="0 {y} -0.05">
  <joint name="{side}_hip_yaw" axis="0 0 1" range="-1 1"/><geom size="0.03"/>
  <body name="{side}_hip_roll_link">
    <joint name="{side}_hip_roll" axis="1 0 0" range="-0.6 0.6"/><geom size="0.03"/>
    <body name="{side}_hip_pitch_link">
      <joint name="{side}_hip_pitch" axis="0 1 0" range="-2 1.5"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.35" size="0.04"/>
      <body name="{side}_knee_link" pos="0 0 -0.35">
        <joint name="{side}_knee" axis="0 1 0" range="0 2.4"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.35" size="0.03"/>
        <body name="{side}_ankle_pitch_link" pos="0 0 -0.35">
          <joint name="{side}_ankle_pitch" axis="0 1 0" range="-1 0.7"/><geom size="0.02"/>
          <body name="{side}_ankle_roll_link">
            <joint name="{side}_ankle_roll" axis="1 0 0" range="-0.4 0.4"/>
            <geom type="box" pos="0.04 0 -0.04" size="0.1 0.035 0.01"/>
          </body>
        </body>
      </body>
    </body>
  </body>
</body>"""
ARM = """
<body name="{side}_shoulder_pitch_link" pos="0 {shoulder} 0.4">
  <joint name="{side}_shoulder_pitch" axis="0 1 0" range="-3 2"/><geom size="0.03"/>
  <body name="{side}_shoulder_roll_link">
    <joint name="{side}_shoulder_roll" axis="1 0 0" range="-2.5 2.5"/><geom size="0.03"/>
    <body name="{side}_shoulder_yaw_link">
      <joint name="{side}_shoulder_yaw" axis="0 0 1" range="-2 2"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.03"/>
      <body name="{side}_elbow_link" pos="0 0 -0.25">
        <joint name="{side}_elbow" axis="0 1 0" range="-2.4 0"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.03"/>
        <body name="{side}_hand_link" pos="0 0 -0.22"><geom size="0.03"/></body>
      </body>
    </body>
  </body>
</body>"""


def biped(*, facing: float = 0.0, free: bool = True, hips: float = 0.09, arms: bool = True) -> str:
    """Return the MJCF text of a robot.

    Args:
        facing: Where it faces in its zero pose, from x to y [deg].
        free: Whether its root has a free joint.
        hips: Distance of a hip from the middle [m].
        arms: Whether it has arms.
    """
    parts = []
    for side, sign in (("left", 1), ("right", -1)):
        parts.append(LEG.format(side=side, y=sign * hips))
        parts.append(ARM.format(side=side, shoulder=sign * 0.16) if arms else "")
    root = "<freejoint/>" if free else ""
    return f"""<mujoco><compiler angle="radian"/><worldbody>
<body name="base" pos="0.3 0.2 1" euler="0 0 {facing * 3.141592653589793 / 180}">{root}
<geom type="box" size="0.06 {hips} 0.06"/>{"".join(parts)}</body></worldbody></mujoco>"""
