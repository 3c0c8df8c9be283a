"""Usual marker sets of motion laboratories: which label lies on which place of the body.

Labels are in capitals without blanks, dots, hyphens and underscores; ``{S}`` is L or R. A place
has several labels where programs spell it differently; the first that a file has is taken. What
the places tell of the nine landmarks stands in :mod:`.markers`.
"""

from collections.abc import Mapping

MARKER_SETS: Mapping[str, Mapping[str, str]] = {
    # Vicon, Plug-in Gait Reference Guide. Joint centres are outputs of that model: a segment's
    # origin is ..O (CLO is the shoulder, HUO the elbow, RAO the wrist), FEP is the hip.
    "Plug-in Gait": {
        "shoulder_centre": "{S}SJC {S}CLO",
        "acromion": "{S}SHO",
        "elbow_centre": "{S}EJC {S}HUO",
        "lateral_elbow": "{S}ELB {S}ELBL {S}LELB",
        "medial_elbow": "{S}ELBM {S}MELB {S}MEP {S}ELM",
        "wrist_centre": "{S}WJC {S}RAO",
        "radial_wrist": "{S}WRA {S}RAD",
        "ulnar_wrist": "{S}WRB {S}ULN",
        "hand_centre": "{S}HNO",
        "middle_knuckle": "{S}FIN {S}HAND",
        "hip_centre": "{S}HJC {S}FEP",
        "asis": "{S}ASI {S}ASIS",
        "psis": "{S}PSI {S}PSIS",
        "sacrum": "SACR SACRUM",
        "head_centre": "HEDO",
        "front_head": "{S}FHD",
        "back_head": "{S}BHD",
        "upper_trunk": "C7 CLAV T2 MAN",
        "lower_trunk": "STRN T10",
        "foot": "{S}ANK {S}HEE {S}TOE",
    },
    # Leardini et al. 2007 and 2011 (Istituto Ortopedico Rizzoli), CAST, and Qualisys' and
    # Visual3D's sets that use the names of Van Sint Jan 2007.
    "IOR, CAST (names of Van Sint Jan)": {
        "shoulder_centre": "{S}SJC",
        "acromion": "{S}SAJ {S}SAE {S}SAA {S}AC",
        "elbow_centre": "{S}EJC",
        "lateral_elbow": "{S}HLE",
        "medial_elbow": "{S}HME",
        "wrist_centre": "{S}WJC",
        "radial_wrist": "{S}RSP",
        "ulnar_wrist": "{S}USP {S}UHE",
        "middle_knuckle": "{S}HM3",
        "second_knuckle": "{S}HM2",
        "fifth_knuckle": "{S}HM5",
        "hip_centre": "{S}HJC",
        "asis": "{S}IAS",
        "psis": "{S}IPS",
        "front_head": "{S}HDF {S}FHD {S}AH",
        "back_head": "{S}HDB {S}BHD {S}PH",
        "upper_trunk": "CV7 SJN SNJ TV2",
        "lower_trunk": "SXS TV8 TV10",
        "foot": "{S}FAL {S}FCC {S}FM1 {S}FM5",
    },
    # {S}LE and {S}ME of Leardini's gait sets are epicondyles of the femur, not of the elbow.
    "Rizzoli (Leardini)": {
        "acromion": "{S}A {S}AC {S}ACR {S}ACROM",
        "lateral_elbow": "{S}EL",
        "medial_elbow": "{S}EM",
        "radial_wrist": "{S}RS {S}RSP",
        "ulnar_wrist": "{S}US {S}USP",
        "second_knuckle": "{S}MH2 {S}HM2",
        "fifth_knuckle": "{S}MH5 {S}HM5",
        "hip_centre": "{S}HJC",
        "asis": "{S}ASIS",
        "psis": "{S}PSIS",
        "front_head": "{S}AH",
        "back_head": "{S}PH",
        "upper_trunk": "C7 IJ T2",
        "lower_trunk": "PX MAI T8",
        "foot": "{S}LM {S}CA {S}FM {S}VM",
    },
    # Qualisys Track Manager, animation and sports sets; OptiTrack's baseline set has these names.
    "Qualisys animation and sports": {
        "acromion": "{S}SHOULDERTOP",
        "lateral_elbow": "{S}ELBOWOUT",
        "medial_elbow": "{S}ELBOWIN",
        "radial_wrist": "{S}WRISTIN",
        "ulnar_wrist": "{S}WRISTOUT",
        "middle_knuckle": "{S}HAND2",
        "second_knuckle": "{S}HANDIN",
        "fifth_knuckle": "{S}HANDOUT",
        "asis": "WAIST{S}FRONT",
        "psis": "WAIST{S}BACK",
        "sacrum": "WAISTBACK",
        "side_head": "HEAD{S}",
        "front_head": "HEADFRONT{S}",
        "upper_trunk": "SPINETOP SPINETHORACIC2 CHEST BACKTOP",
        "lower_trunk": "SPINETHORACIC12 SPINEMID",
        "foot": "{S}ANKLEOUT {S}HEELBACK {S}FOREFOOTOUT {S}TOETIP",
    },
    # OpenSim: Rajagopal et al. 2016, and Pose2Sim's models that have its markers.
    "Rajagopal (OpenSim)": {
        "shoulder_centre": "{S}SJC",
        "acromion": "{S}ACR",
        "elbow_centre": "{S}EJC",
        "lateral_elbow": "{S}LEL",
        "medial_elbow": "{S}MEL",
        "wrist_centre": "{S}WJC",
        "radial_wrist": "{S}FARADIUS",
        "ulnar_wrist": "{S}FAULNA",
        "hip_centre": "{S}HJC",
        "asis": "{S}ASI",
        "psis": "{S}PSI",
        "upper_trunk": "C7 CLAV",
        "foot": "{S}AJC {S}CAL {S}TOE {S}MT5",
    },
    # OpenSim: gait2354 and gait2392, such as R.Acromium.
    "gait2392 (OpenSim)": {
        "acromion": "{S}ACROMIUM {S}ACROMION",
        "lateral_elbow": "{S}ELBOWLAT",
        "medial_elbow": "{S}ELBOWMED",
        "radial_wrist": "{S}WRISTLAT",
        "ulnar_wrist": "{S}WRISTMED",
        "asis": "{S}ASIS",
        "psis": "{S}PSIS",
        "sacrum": "VSACRAL",
        "lower_trunk": "STERNUM",
        "foot": "{S}ANKLELAT {S}HEEL {S}TOETIP",
    },
    # OpenCap's augmented markers, such as r_shoulder_study.
    "OpenCap": {
        "acromion": "{S}SHOULDERSTUDY",
        "lateral_elbow": "{S}LELBOWSTUDY",
        "medial_elbow": "{S}MELBOWSTUDY",
        "radial_wrist": "{S}LWRISTSTUDY",
        "ulnar_wrist": "{S}MWRISTSTUDY",
        "hip_centre": "{S}HJCSTUDY",
        "asis": "{S}ASISSTUDY",
        "psis": "{S}PSISSTUDY",
        "upper_trunk": "C7STUDY",
        "foot": "{S}ANKLESTUDY {S}CALCSTUDY {S}TOESTUDY",
    },
}
"""Labels of each place, of its sides with ``{S}`` in them, by the name of the set; of two sets that
have as many of a file's labels, the first one is taken."""
