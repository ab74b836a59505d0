"""The published figures that started this, for comparison of scale: T. Flemming, bachelor thesis, Hamburg 2019."""

from decimal import Decimal

from realitygap.report.folder import Results

PUBLISHED = (
    # motion, joints, URDF, position [°], velocity [°/s], effort [N·m]: tables 5.4 and 5.5, which repeat 5.1 and 5.2;
    # recorded on grass
    ("cheering", "moving", "old", "0.6062", "0.7271", "1.9947"),
    ("cheering", "moving", "link revised", "0.4305", "0.7071", "0.4445"),
    ("cheering", "moving", "new", "0.3138", "1.6838", "0.2798"),
    ("cheering", "unmoving", "old", "1.0869", "0.0643", "0.9330"),
    ("cheering", "unmoving", "link revised", "1.4582", "0.0643", "0.9331"),
    ("cheering", "unmoving", "new", "0.6918", "0.2330", "0.5792"),
    ("kick", "moving", "old", "0.6917", "0.7325", "0.5710"),
    ("kick", "moving", "link revised", "1.1325", "0.9631", "0.9993"),
    ("kick", "moving", "new", "0.5606", "1.0626", "0.4622"),
    ("kick", "unmoving", "old", "0.5446", "0.3859", "0.4841"),
    ("kick", "unmoving", "link revised", "0.5064", "0.0665", "0.3949"),
    ("kick", "unmoving", "new", "0.3625", "0.0651", "0.1702"),
)


HEAD = (
    # table 5.3: a quick turn of the head, the one joint that moves
    ("old", "1.1258", "39.5268", "0.8825"),
    ("link revised", "1.2376", "44.4872", "0.7342"),
)
ON_FLAT_GROUND = (
    # table 6.1: cheering with the new URDF, recorded on flat ground
    ("moving", "0.3345", "0.6742", "1.6723"),
    ("unmoving", "0.5512", "0.2366", "0.4414"),
)


def grounds() -> list[tuple[str, ...]]:
    """Table 6.1: joints, recorded ground and gaps of the cheering with the new URDF.

    Its rows of grass are printed with the kick's figures; here stand those of the cheering, from table 5.4.
    """
    grass = {joints: values for motion, joints, urdf, *values in PUBLISHED if (motion, urdf) == ("cheering", "new")}
    return [
        row for joints, *flat in ON_FLAT_GROUND for row in ((joints, "flat", *flat), (joints, "grass", *grass[joints]))
    ]


def improvements() -> list[tuple[str, ...]]:
    """Table 5.6: motion, joints, and by how much the gap of the new URDF is smaller than that of the old one."""
    found = {row[:3]: row[3:] for row in PUBLISHED}
    pairs = [(key[:2], old, found[*key[:2], "new"]) for key, old in found.items() if key[2] == "old"]
    return [(*key, *(f"{Decimal(a) - Decimal(b):+}" for a, b in zip(old, new, strict=True))) for key, old, new in pairs]


def is_wolfgang(results: Results) -> bool:
    """Whether the scenarios are those of the thesis' robot."""
    return any("wolfgang" in str(s).lower() for s in [*results.axes["scenario"], *results.axes["robot_revision"]])
