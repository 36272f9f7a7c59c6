"""Landmarks of marker names in the marker sets of laboratories.

The names are those of Plug-in Gait and CGM2 (``LASI``, ``LKNM``, ``LFMH``; pyCGM2), Helen Hayes
and Cleveland (``V.Sacral``, ``R.Knee.Medial``, ``R.Offset``), CAST (``RME``, ``RSM``), the
Rizzoli protocols [Leardini2007]_ and Qualisys (``RIAS``, ``RFLE``, ``RFMT``, ``SXS``), the CMU data
base with its 41 markers (``LFWT``, ``RBAC``; placed as ``labels_map`` of moshpp says), the KIT data
base (``LAEL``, ``LWTS``), the Human Body Model (``RLKE``, ``XYPH``), OptiTrack (``WaistLFront``,
``LKneeOut``), OpenCap (``r_mknee_study``) and Xsens (``pRightASI``, ``jRightKnee``).
"""

import re

from plantigrade.data_files import spelling_tables

SPELLINGS, MIDLINE = spelling_tables("spellings.csv")
# Endings of names of joint centres: the method of computation, or longer words.
_REGRESSED = r"REG|REGRESSION|HARRINGTON|BELL|DAVIS|EST"
_ESTIMATE = re.compile(
    rf"(JC|JOINT|JOINTCENT(RE|ER)|CENT(RE|ER))({_REGRESSED}|FUN|FUNC|FUNCTIONAL|SCORE|SARA)?$"
)
_BY_SPELLING = {s: mark for mark, words in SPELLINGS.items() for s in words}
_BY_SPELLING |= {re.sub("_", "", mark).upper(): mark for mark in SPELLINGS}
_BY_MIDLINE = {s: mark for mark, words in MIDLINE.items() for s in words}
# Names with the side in the middle; OptiTrack's front of the waist lies on the iliac spines.
_WHOLE = {f"WAIST{side}FRONT": f"asis_{side.lower()}" for side in "RL"}


def landmark_of(name: str) -> str | None:
    """Return the landmark with this marker name among its spellings, or None.

    Example:
        >>> landmark_of("R.ASIS"), landmark_of("LKNE"), landmark_of("sacrum"), landmark_of("RTH2")
        ('asis_r', 'knee_lateral_l', 'sacrum', None)
        >>> landmark_of("R_HJC_reg"), landmark_of("LKneeJointCentre")
        ('hip_joint_r', 'knee_joint_l')
        >>> landmark_of("pLeftASI"), landmark_of("jRightKnee")
        ('asis_l', 'knee_joint_r')
    """
    xsens = re.fullmatch("([pj])([A-Z].*)", name)  # a point on the body, or a joint
    if xsens:
        joint = xsens[1] == "j" and xsens[2].startswith(("Right", "Left"))
        name = xsens[2] + ("Joint" if joint else "")
    plain = _ESTIMATE.sub("JC", _plain(name))
    if plain in _WHOLE:
        return _WHOLE[plain]
    if plain in _BY_MIDLINE:
        return _BY_MIDLINE[plain]
    for word, side in (("RIGHT", "r"), ("LEFT", "l"), ("R", "r"), ("L", "l")):
        for rest in (plain.removeprefix(word), plain.removesuffix(word)):
            if rest != plain and rest in _BY_SPELLING:
                return f"{_BY_SPELLING[rest]}_{side}"
    return None


def is_regressed(name: str) -> bool:
    """Return whether a marker name denotes a joint centre computed by a regression.

    Example:
        >>> is_regressed("R_HJC_reg"), is_regressed("R_HJC")
        (True, False)
    """
    found = _ESTIMATE.search(_plain(name))
    return found is not None and re.fullmatch(_REGRESSED, found[4] or "") is not None


def _plain(name: str) -> str:
    """Return a name in capitals, without punctuation and OpenCap's ending."""
    return re.sub(r"[^A-Z0-9]", "", name.upper()).removesuffix("STUDY")
