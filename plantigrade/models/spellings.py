"""Landmarks of marker names in the marker sets of laboratories.

The names are those of Plug-in Gait and CGM2 (``LASI``, ``LKNM``, ``LFMH``; pyCGM2), Helen Hayes
and Cleveland (``V.Sacral``, ``R.Knee.Medial``, ``R.Offset``), CAST (``RME``, ``RSM``), the
Rizzoli protocols [Leardini2007]_ and Qualisys (``RIAS``, ``RFLE``, ``RFMT``, ``SXS``), the CMU data
base with its 41 markers (``LFWT``, ``RBAC``; placed as ``labels_map`` of moshpp says), the KIT data
base (``LAEL``, ``LWTS``), the Human Body Model (``RLKE``, ``XYPH``), OptiTrack (``WaistLFront``,
``LKneeOut``), OpenCap (``r_mknee_study``) and Xsens (``pRightASI``, ``jRightKnee``).
"""

import re

# Common spellings, without side and separators, upper case.
SPELLINGS: dict[str, str] = {
    "asis": "ASI ASIS IAS",
    "psis": "PSI PSIS IPS",
    # on a belt at the iliac spines, placed by eye
    "waist_front": "FWT FWAIST FRONTWAIST",
    "waist_back": "BWT BWAIST BACKWAIST",
    "iliac_crest": "CSI IC ICR ILC ILCR CREST ILIAC ILIACCREST ICT",
    "trochanter": "FTC TROC GT GTR GTRO GTROC GREATERTROCHANTER TROCHANTER",
    "hip_joint": "HJC HIPJC",
    "knee_joint": "KJC KNEEJC",
    "ankle_joint": "AJC ANKLEJC",
    "shoulder_joint": "SJC SHOULDERJC GHJC",
    "elbow_joint": "EJC ELBOWJC",
    "wrist_joint": "WJC WRISTJC",
    "thigh": "THI THIGH LTHI THILAT LATTHIGH",
    "thigh_front": "THIGHFRONT",
    "knee_lateral": (
        "KNE KNEE KNEELAT LKNE LKNEE LEK FLE LFC LATKNEE KNEELATERAL LCON KNEL LE LATEPICONDYLE "
        "KNEELATEPICONDYLE LKE KNEEOUT"
    ),
    "knee_medial": (
        "KNM KNEEMED MKNE MKNEE MEK FME MFC MEDKNEE KNEEMEDIAL MCON KNEM ME MEDEPICONDYLE "
        "KNEEMEDEPICONDYLE MKE KNI KNEEIN"
    ),
    "patella": "PAT PATELLA PAS",
    "fibula_head": "HFB FAX FH HF FIB FIBULA",
    "tibial_tuberosity": "TUB TTC TT TTUB TTU TIBIALTUB",
    "shank": "TIB SHANK SHA LSHA TIBIA LATSHANK",
    "shank_front": "SHN SHIN ATI",
    "ankle_lateral": (
        "ANK ANKLE ANKLELAT LM LMAL LMALL LANK FAL MALL LATANK LATMAL ANKLELATERAL ANKL "
        "LMALLEOLUS LATERALMALLEOLUS LATMALLEOLUS ANKLEOUT"
    ),
    "ankle_medial": (
        "MMA MM MMAL MMALL MANK MANKLE TAM ANKLEMED MEDANK MEDMAL ANKLEMEDIAL ANKM "
        "MMALLEOLUS MEDIALMALLEOLUS MEDMALLEOLUS ANKLEIN"
    ),
    "heel": "HEE HEEL CAL FCC CA CALC CALCANEUS HEELFOOT",
    "heel_upper": "PCA",
    "heel_wand": "CPG",
    "heel_lateral": "LCA",
    "sustentaculum": "STL SUST",
    "navicular": "NAV NAVICULAR",
    "metatarsal_1_base": "P1M",
    "metatarsal_1_head": (
        "D1M MT1 FM1 MTP1 MTH1 FM FMH FMT 1MTH M1 MET1 1MT 1META FIRSTMETATARSAL TOEIN"
    ),
    "metatarsal_2_head": "MT2 FM2 MTP2 MTH2 2MTH M2 MET2 MT3 MTH3 MT23 2MT TOE SM SMH SMT",
    "metatarsal_5_base": "P5M",
    "metatarsal_5_head": (
        "D5M MT5 FM5 MTP5 MTH5 VM VMH VMT 5MTH M5 MET5 5MT 5META FIFTHMETATARSAL TOEOUT"
    ),
    "hallux": "HLX HAL HALLUX BTOE GTOE BIGTOE GREATTOE DM",
    "toe_tip": "TOETIP TTIP TIPTOE",
    "acromion": "SHO SHOULDER ACROMION ACROMIUM ACR SAE AC ACRO SHOULDERTOP",
    "clavicle": "CLAVICLE CLA",
    "scapula": "BAK BAC SCAP SCAPULA IAN OFFSET",
    "upper_arm": "UPA BICEP BICEPS UPPERARM ARM UARM HUMERUS",
    "elbow_lateral": (
        "ELB ELBOW HLE ELBLAT LELB LEL ELBOWLAT LATELB LEE ELBL LELBOW AEL ARMLATEPICONDYLE "
        "ELBOWOUT"
    ),
    "elbow_medial": "MELB ELBM HME MELBOW ELBMED MEL ELBOWMED MEDELB MEE ARMMEDEPICONDYLE",
    "elbow_rear": "AOL OLECRANON",
    "forearm": "FRM FRA FOREARM FARM FASUPERIOR",
    "wrist_radial": (
        "WRA WRISTLAT WRISTRAD WRISTRADIUS FARADIUS RSP RS RADIUS WRR WRIRAD LWRI LWRIST "
        "LW IWR INWRIST WTS RADIALSTYLOID WRISTIN"
    ),
    "wrist_ulnar": (
        "WRB WRISTMED WRISTULN WRISTULNA FAULNA USP US ULNA WRU WRIULN MWRI MWRIST "
        "MW OWR OUTWRIST WPS ULNARSTYLOID WRISTOUT"
    ),
    "wrist": "WRIST WRI",
    "hand": "FIN HAND HM3 MC3 MCP3 3MCP KNUCKLE TOPOFHAND",
    "hand_radial": "HM2 MC2 MCP2 2MCP HTS IHAND",
    "hand_ulnar": "HM5 MC5 MCP5 5MCP HPS OHAND PINKY",
    "head_front": "FHD HEADFRONT",
    "head_back": "BHD HEADBACK",
    "temple": "TEMPLE HEAD HD",
    "ear": "EAR TRAGUS MAS MASTOID AURICULARIS",
}
MIDLINE: dict[str, str] = {
    "sacrum": "SACR SAC SACRUM SACRAL VSAC VSACR VSACRAL VSACRUM S2 S1 MIDPSIS MPSI",
    "c7": "C7 CV7 VC7 C7SPINALPROCESS BACKTOP",
    "t2": "T2 TV2",
    "t4": "T4 TV4 T4SPINALPROCESS",
    "t6": "T6 TV6",
    "t8": "T7 TV7 T8 TV8 T8SPINALPROCESS MAI",
    "t10": "T10 TV10",
    "t12": "T12 TV12 T12SPINALPROCESS",
    "l3": "L3 LV3 L3SPINALPROCESS",
    "l5": "L5 LV5 L5S1 L5SPINALPROCESS",
    "suprasternale": "CLAV IJ JN SJN SNJ SN MAN JUGULARNOTCH STERNALNOTCH MANUBRIUM",
    "sternum": "STERNUM STER STE CHEST",
    "xiphoid": "XIPH XYPH PX SXS XIPHOID STRN",
    "vertex": "TOPHEAD HEADTOP THEAD VERTEX TOPOFHEAD ARIEL TOP",
    "forehead": "FOREHEAD HEADFRONT FHEAD FRONTHEAD GLAB SGL",
    "occiput": "OCCIPUT HEADREAR BACKHEAD BHEAD REARHEAD BACKOFHEAD",
}
# Endings of names of joint centres: the method of computation, or longer words.
_REGRESSED = r"REG|REGRESSION|HARRINGTON|BELL|DAVIS|EST"
_ESTIMATE = re.compile(
    rf"(JC|JOINT|JOINTCENT(RE|ER)|CENT(RE|ER))({_REGRESSED}|FUN|FUNC|FUNCTIONAL|SCORE|SARA)?$"
)
_BY_SPELLING = {s: mark for mark, words in SPELLINGS.items() for s in words.split()}
_BY_SPELLING |= {re.sub("_", "", mark).upper(): mark for mark in SPELLINGS}
_BY_MIDLINE = {s: mark for mark, words in MIDLINE.items() for s in words.split()}
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
