"""OpenSim models written for the tests."""

JOINTS = """
<FreeJoint name="free"><socket_parent_frame>/ground</socket_parent_frame>
 <socket_child_frame>off</socket_child_frame>
 <coordinates>{free}</coordinates>
 <frames><PhysicalOffsetFrame name="off"><socket_parent>/bodyset/a</socket_parent>
  <translation>0.1 -0.2 0.3</translation><orientation>0.2 -0.4 0.3</orientation>
 </PhysicalOffsetFrame></frames></FreeJoint>
<BallJoint name="ball"><socket_parent_frame>up</socket_parent_frame>
 <socket_child_frame>/bodyset/b</socket_child_frame>
 <coordinates>{ball}</coordinates>
 <frames><PhysicalOffsetFrame name="up"><socket_parent>/bodyset/a</socket_parent>
  <translation>0 0.3 0</translation><orientation>0.5 0.1 -0.3</orientation>
 </PhysicalOffsetFrame></frames></BallJoint>
<UniversalJoint name="uni"><socket_parent_frame>/bodyset/b</socket_parent_frame>
 <socket_child_frame>low</socket_child_frame>
 <coordinates>{uni}</coordinates>
 <frames><PhysicalOffsetFrame name="low"><socket_parent>/bodyset/c</socket_parent>
  <translation>0.05 -0.3 0.02</translation><orientation>0.1 0.2 0.3</orientation>
 </PhysicalOffsetFrame></frames></UniversalJoint>
<SliderJoint name="slider"><socket_parent_frame>/bodyset/c</socket_parent_frame>
 <socket_child_frame>/bodyset/d</socket_child_frame>
 <coordinates>{slider}</coordinates></SliderJoint>
<CustomJoint name="custom"><socket_parent_frame>/bodyset/a</socket_parent_frame>
 <socket_child_frame>under</socket_child_frame>
 <coordinates>{custom}</coordinates>
 <frames><PhysicalOffsetFrame name="under"><socket_parent>/bodyset/e</socket_parent>
  <translation>0 0.3 0.01</translation><orientation>-0.2 0.1 0.4</orientation>
 </PhysicalOffsetFrame></frames>
 <SpatialTransform>
  <TransformAxis name="rotation1"><coordinates>bend</coordinates><axis>0 0 1</axis>
   <LinearFunction><coefficients>-1 0</coefficients></LinearFunction></TransformAxis>
  <TransformAxis name="rotation2"><coordinates></coordinates><axis>1 0 0</axis>
   <Constant><value>0.3</value></Constant></TransformAxis>
  <TransformAxis name="rotation3"><coordinates>twist</coordinates><axis>0 1 0.2</axis>
   <MultiplierFunction><function><LinearFunction><coefficients>1 0</coefficients>
    </LinearFunction></function><scale>1</scale></MultiplierFunction></TransformAxis>
  <TransformAxis name="translation1"><coordinates>bend</coordinates><axis>1 0 0</axis>
   <SimmSpline><x>-1 -0.3 0.2 0.7 1.2</x><y>0.01 -0.02 0.03 0.02 0</y></SimmSpline>
  </TransformAxis>
  <TransformAxis name="translation2"><coordinates></coordinates><axis>0 1 0</axis>
   <Constant><value>-0.4</value></Constant></TransformAxis>
  <TransformAxis name="translation3"><coordinates>twist</coordinates><axis>0 0 1</axis>
   <PolynomialFunction><coefficients>0.3 0.2 0.1</coefficients></PolynomialFunction>
  </TransformAxis>
 </SpatialTransform></CustomJoint>
<PinJoint name="pin"><socket_parent_frame>/bodyset/e</socket_parent_frame>
 <socket_child_frame>/bodyset/f</socket_child_frame>
 <coordinates>{pin}</coordinates></PinJoint>
<WeldJoint name="weld"><socket_parent_frame>/bodyset/f</socket_parent_frame>
 <socket_child_frame>/bodyset/g</socket_child_frame></WeldJoint>
"""
COORDINATES = {
    "free": ("rx", "ry", "rz", "tx", "ty", "tz"),
    "ball": ("b1", "b2", "b3"),
    "uni": ("u1", "u2"),
    "slider": ("s",),
    "custom": ("bend", "twist"),
    "pin": ("p",),
}


def every_joint() -> str:
    """Return a model with a joint of every kind and a coordinate tied to another."""
    bodies = "".join(
        f'<Body name="{name}"><mass>{k + 1}</mass><mass_center>0.01 -0.1 0.02</mass_center>'
        f"<inertia>0.02 0.03 0.025 0.001 0 -0.002</inertia></Body>"
        for k, name in enumerate("abcdefg")
    )
    joints = JOINTS.format(
        **{
            joint: "".join(
                f'<Coordinate name="{n}"><range>-2 2</range></Coordinate>' for n in names
            )
            for joint, names in COORDINATES.items()
        }
    )
    tie = (
        '<CoordinateCouplerConstraint name="tie"><coupled_coordinates_function><LinearFunction>'
        "<coefficients>0.5 0.1</coefficients></LinearFunction></coupled_coordinates_function>"
        "<independent_coordinate_names>bend</independent_coordinate_names>"
        "<dependent_coordinate_name>p</dependent_coordinate_name></CoordinateCouplerConstraint>"
    )
    marker = (
        '<Marker name="M"><socket_parent_frame>/bodyset/g</socket_parent_frame>'
        "<location>0.1 0.2 0.3</location></Marker>"
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<OpenSimDocument Version="40000">'
        '<Model name="every"><gravity>0 -9.81 0</gravity>'
        f'<BodySet name="bodyset"><objects>{bodies}</objects></BodySet>'
        f'<JointSet name="jointset"><objects>{joints}</objects></JointSet>'
        f'<ConstraintSet name="constraintset"><objects>{tie}</objects></ConstraintSet>'
        f'<MarkerSet name="markerset"><objects>{marker}</objects></MarkerSet>'
        "</Model></OpenSimDocument>"
    )
