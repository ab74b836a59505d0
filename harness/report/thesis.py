"""The published figures that started this, for comparison of scale: T. Flemming, bachelor thesis, Hamburg 2019."""

from harness.report.folder import Results

PUBLISHED = (
    # motion, joints, URDF, position [°], velocity [°/s], effort [N·m]: tables 5.4 and 5.5, both on grass
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


def is_wolfgang(results: Results) -> bool:
    """Whether the scenarios are those of the thesis' robot."""
    return any("wolfgang" in str(s).lower() for s in [*results.axes["scenario"], *results.axes["robot_revision"]])
