"""The straight line between torque and speed of a DC motor at one supply voltage."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from realitygap.bench.estimate import Estimate

Array = NDArray[np.float64]
Regression = Literal["torque_on_speed", "speed_on_torque"]


@dataclass(frozen=True)
class TorqueSpeedLine:
    """A fitted line and the extremes of what was measured.

    Attributes:
        stall_torque: torque at no speed [N·m].
        no_load_speed: speed at no torque [rad/s].
        max_torque: the largest torque measured [N·m].
        max_speed: the largest speed measured [rad/s], and `torque_at_max_speed` [N·m] there.
        r_squared: share of the variance that the line explains.
        curvature_p: probability of so much curvature if the relation were straight (F-test of a square term).
        other_stall_torque: what the regression the other way round gives [N·m]; the truth lies between the two where
            both variables carry error.
        other_no_load_speed: the same for the speed [rad/s].
        points: number of measurements.
    """

    stall_torque: Estimate
    no_load_speed: Estimate
    max_torque: float
    max_speed: float
    torque_at_max_speed: float
    r_squared: float
    curvature_p: float
    other_stall_torque: float
    other_no_load_speed: float
    points: int


def fit_line(speed: Array, torque: Array, regression: Regression = "torque_on_speed") -> TorqueSpeedLine:
    """The line through torques [N·m] at speeds [rad/s]. Both Shape (n,), n >= 3.

    Torque on speed is the default: the speed comes from an encoder or a gyroscope, whose error is far below one per
    cent of the range, while the torque carries the motor's own scatter (friction, torque ripple, motor to motor), the
    sensor's bias and the lever's inertia. Least squares wants the error in the variable that is regressed. Where the
    torque is exact (a weight, standing still) and the speed is the noisy answer, ask for speed on torque.

    Raises:
        ValueError: where the torque does not fall with speed.
    """
    if regression == "torque_on_speed":
        stall, no_load, slope = _intercepts(speed, torque)
        other_no_load, other_stall, _ = _intercepts(torque, speed)
    else:
        no_load, stall, slope = _intercepts(torque, speed)
        other_stall, other_no_load, _ = _intercepts(speed, torque)
    if not slope < 0:
        raise ValueError("the torque does not fall with speed")
    fastest = int(np.argmax(speed))
    return TorqueSpeedLine(
        stall_torque=stall,
        no_load_speed=no_load,
        max_torque=float(torque.max()),
        max_speed=float(speed[fastest]),
        torque_at_max_speed=float(torque[fastest]),
        r_squared=float(np.corrcoef(speed, torque)[0, 1] ** 2),
        curvature_p=_curvature(speed, torque) if regression == "torque_on_speed" else _curvature(torque, speed),
        other_stall_torque=other_stall.value,
        other_no_load_speed=other_no_load.value,
        points=len(speed),
    )


def _intercepts(x: Array, y: Array) -> tuple[Estimate, Estimate, float]:
    """Where the regression of y on x meets the y and the x axis, with 95 % intervals, and its slope.

    The y intercept is a regression coefficient; the x intercept is a ratio, whose interval is Fieller's (1954).
    """
    fit = stats.linregress(x, y)
    quantile = float(stats.t.ppf(0.975, len(x) - 2))
    half = quantile * fit.intercept_stderr
    on_y = Estimate(float(fit.intercept), float(fit.intercept - half), float(fit.intercept + half))
    if fit.slope == 0:
        return on_y, Estimate(np.nan, np.nan, np.nan), 0.0
    # (a + b·x)² <= t²·var(a + b·x), a quadratic in x
    a, b, va, vb = fit.intercept, fit.slope, fit.intercept_stderr**2, fit.stderr**2
    cov = -float(np.mean(x)) * vb
    q2, q1, q0 = b * b - quantile**2 * vb, a * b - quantile**2 * cov, a * a - quantile**2 * va
    root = q1 * q1 - q2 * q0
    if q2 <= 0 or root < 0:  # the slope itself is not told apart from zero
        low, high = -np.inf, np.inf
    else:
        low, high = sorted(((-q1 - np.sqrt(root)) / q2, (-q1 + np.sqrt(root)) / q2))
    return on_y, Estimate(float(-a / b), float(low), float(high)), float(fit.slope)


def _curvature(x: Array, y: Array) -> float:
    """The p-value of a square term; NaN where there are too few points or none are off the line."""
    if len(x) < 4 or len(np.unique(x)) < 3:
        return float("nan")
    scaled = (x - x.mean()) / np.ptp(x)
    straight = np.vander(scaled, 2)
    bent = np.vander(scaled, 3)
    rest = [float(np.sum((y - A @ np.linalg.lstsq(A, y, rcond=None)[0]) ** 2)) for A in (straight, bent)]
    if rest[0] <= 1e-20 * float(np.sum((y - y.mean()) ** 2)):
        return float("nan")
    if rest[1] <= 1e-12 * rest[0]:
        return 0.0
    degrees = len(x) - 3
    return float(stats.f.sf((rest[0] - rest[1]) / (rest[1] / degrees), 1, degrees))
