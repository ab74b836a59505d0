"""Names, units and colours that figures and page share. Colours: Okabe and Ito (2008), told apart by every eye."""

import math

ENGINES = {
    "mujoco": ("MuJoCo", "#0072b2"),
    "dart": ("DART", "#d55e00"),
    "drake": ("Drake", "#009e73"),
    "pybullet": ("PyBullet", "#cc79a7"),
    "ode": ("ODE", "#b8860b"),
    "simbody": ("Simbody", "#56b4e9"),
    "exudyn": ("Exudyn", "#8c6bb1"),
}
OTHERS = ("#737373", "#a6761d", "#44aa99", "#332288")

SIGNALS = {
    "position": "position",
    "velocity": "velocity",
    "effort": "effort",
    "base_position": "base position",
    "base_orientation": "base orientation",
    "base_angular_velocity": "base angular velocity",
}

DIGITS = 3
"""Significant digits of a value that people read, on pages and in a terminal."""

RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
"""Digits, and what they are as an exponent."""

UNITS = {"deg": "°", "deg/s": "°/s"}

AXES = {
    "scenario": "scenario",
    "recording": "recording",
    "robot_revision": "revision",
    "engine": "engine",
    "ground": "ground",
    "step_rate": "step rate",
    "solver_iterations": "iterations",
    "overrides": "overrides",
}
"""The columns that tell cells apart, and what people call them."""


def engine_label(name: str) -> str:
    """The engine's name as its authors write it."""
    return ENGINES.get(name, (name, ""))[0]


def engine_color(name: str, among: list[str]) -> str:
    """The engine's colour; an engine that is not in the table gets one by its place among the unknown ones."""
    if name in ENGINES:
        return ENGINES[name][1]
    unknown = [n for n in among if n not in ENGINES]
    return OTHERS[unknown.index(name) % len(OTHERS)]


def engine_dashes(name: str, among: list[str]) -> int:
    """Which of seven dash patterns is the engine's: the second sign, beside the colour, that tells curves apart."""
    return list(ENGINES).index(name) if name in ENGINES else (len(ENGINES) - 1 + among.index(name)) % len(ENGINES)


def unit_label(unit: str) -> str:
    """The unit as it is printed behind a number."""
    return UNITS.get(unit, unit)


def number(value: float, digits: int = DIGITS) -> str:
    """A few significant digits; beyond 10⁶ and below 10⁻⁴ with an exponent, as people write it."""
    if math.isnan(value):
        return "unknown"
    if math.isinf(value):
        return "∞"
    if value == 0:
        return "0"
    if not 1e-4 <= abs(value) < 1e6:
        mantissa, decades = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa}·{power_of_ten(int(decades))}".replace("-", "−")
    places = max(digits - 1 - math.floor(math.log10(abs(value))), 0)
    return f"{value:.{places}f}".replace("-", "−")


def power_of_ten(decades: int) -> str:
    """So many decades as people write them: 10⁶."""
    return f"10{str(decades).translate(RAISED)}"


def quantity(value: float, unit: str, digits: int = DIGITS) -> str:
    """A number with its unit: 0.520°, 1.68 °/s, 0.280 N·m."""
    label = unit_label(unit)
    return number(value, digits) + ("" if label == "°" else " ") + label


def axis_value(axis: str, value: object) -> str:
    """The value of an axis in words."""
    if axis == "engine":
        return engine_label(str(value))
    if axis == "step_rate":
        return f"{float(str(value)):g} Hz"
    if axis == "solver_iterations":
        return f"{value} iterations" if value not in ("", None) else "the engine's own iterations"
    return str(value) if value not in ("", None) else "none"
