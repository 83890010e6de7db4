"""Assessment of synthetic signals by scipy's filters and numpy's percentiles: writes tests/data/assess.json. Shares nothing with the Rust code but the
definitions (docs/assess.md) and the signals' formula. Run: python tests/reference/assess.py > tests/data/assess.json   (numpy 2.4, scipy 1.17)
"""
import json
import sys

import numpy as np
from scipy import signal
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicHermiteSpline, CubicSpline

RATE, DURATION, LOAD = 500.0, 320.0, 100e3
t = np.arange(int(RATE * DURATION) + 1) / RATE


def waves(channel, mean, size):
    """Sum of 14 modulated sines from 0.23 to 44 Hz; the same formula stands in tests/validate/assess.rs."""
    out = np.full_like(t, mean)
    for j in range(1, 15):
        phase = 2 * np.pi * ((0.618033988749895 * j * (channel + 1)) % 1.0)
        out += size / j**0.5 * (1 + 0.5 * np.sin(0.02 * j * t + channel)) * np.sin(2 * np.pi * 0.15 * 1.5**j * t + phase)
    return out


def sosfilt(sos, x):
    return signal.sosfilt(sos, x, zi=signal.sosfilt_zi(sos) * x[0])[0]


def low(x, f):
    return sosfilt(signal.butter(4, f, fs=RATE, output="sos"), x)


def band(x, a, b):
    high = signal.butter(4, a, "highpass", fs=RATE, output="sos")
    return low(signal.sosfilt(high, x, zi=signal.sosfilt_zi(high) * x[0])[0], b)


def sliding(s, q, window, step):
    integral = CubicHermiteSpline(s, cumulative_trapezoid(q, s, initial=0.0), q)
    ends = s[0] + window + step * np.arange(int(np.floor((s[-1] - s[0] - window) / step + 1e-9)) + 1)
    return (integral(ends) - integral(ends - window)) / window


distance = 20.0 * t + 0.3 * np.sin(0.5 * t)
left, right = (waves(1, -6e3, 1.5e3), waves(2, 3e3, 1.2e3))  # lateral force on the wheel, left positive
q_left, q_right = (waves(3, 52e3, 2.5e3), waves(4, 47e3, 2.5e3))
wear = [np.abs(waves(5, 30.0, 10.0)), np.abs(waves(6, 50.0, 10.0))]
ax, ay, az = (waves(7, 0.0, 0.02), waves(8, 0.3, 0.08), waves(9, 9.81, 0.1))


def sections(length):
    for k in range(int((distance[-1] - distance[0]) / length + 1e-6)):
        a = distance[0] + length * k
        yield slice(np.searchsorted(distance, a, "left"), np.searchsorted(distance, a + length, "right"))


def extreme(x):
    return max(abs(np.percentile(x, 0.15)), abs(np.percentile(x, 99.85)))


def estimate(of, length, k):
    values = [of(section) for section in sections(length)]
    return np.mean(values) + k * np.std(values, ddof=1)


def means(x, section):
    return sliding(distance[section], x[section], 2.0, 0.5)


def en14363(length):
    sum_y = low(-(left + right), 20.0)
    quotients = [low(-left / q_left, 20.0), low(right / q_right, 20.0)]
    found = {
        "sum_y": estimate(lambda s: extreme(means(sum_y, s)), length, 3.0),
        "y_over_q": max(estimate(lambda s: np.percentile(means(y, s), 99.85), length, 3.0) for y in quotients),
        "q_max": max(estimate(lambda s: np.percentile(q[s], 99.85), length, 2.2) for q in (low(q_left, 20.0), low(q_right, 20.0))),
        "acc_y_safety": estimate(lambda s: extreme(y_body[s]), length, 3.0),
        "acc_z_safety": estimate(lambda s: extreme(z_body[s]), length, 3.0),
        "acc_y_ride": estimate(lambda s: extreme(y_ride[s]), length, 2.2),
        "acc_z_ride": estimate(lambda s: extreme(z_ride[s]), length, 2.2),
        "rms_y_ride": estimate(lambda s: np.sqrt(np.mean(y_ride[s] ** 2)), length, 2.2),
        "rms_z_ride": estimate(lambda s: np.sqrt(np.mean(z_ride[s] ** 2)), length, 2.2),
    }
    if length < 100.0:
        found["y_qst"] = max(estimate(lambda s: np.median(y[s]), length, 0.0) for y in (low(-left, 20.0), low(right, 20.0)))
        found["q_qst"] = max(estimate(lambda s: np.median(q[s]), length, 0.0) for q in (low(q_left, 20.0), low(q_right, 20.0)))
        found["acc_y_qst"] = estimate(lambda s: abs(np.median(low(ay, 20.0)[s])), length, 0.0)
    return found


y_body, z_body = low(ay, 6.0), band(az, 0.4, 4.0)
y_ride, z_ride = band(ay, 0.4, 10.0), band(az, 0.4, 10.0)

# The whole run.
raw = -(left + right)
spectrum = np.abs(np.fft.rfft((raw - raw.mean()) * signal.get_window("hann", raw.size)))
lines = np.fft.rfftfreq(raw.size, 1 / RATE)
inside = (lines >= 2.4) & (lines <= 10.0)
f0 = lines[inside][np.argmax(spectrum[inside])]
run = {"sum_y_rms": np.sqrt(sliding(distance, band(raw, f0 - 2.0, f0 + 2.0) ** 2, 100.0, 10.0).max())}
angle, friction = np.radians(70.0), 0.35
limit = (np.tan(angle) - friction) / (1 + friction * np.tan(angle))
run["nadal"] = max(sliding(distance, low(y, 20.0), 2.0, 0.5).max() for y in (-left / q_left, right / q_right)) / limit
run["unloading"] = 1 - min(sliding(distance, low(q, 20.0), 2.0, 0.5).min() for q in (q_left, q_right)) / (0.5 * LOAD)
wears = [np.trapezoid(w, distance) / (distance[-1] - distance[0]) for w in wear]
run["t_gamma"], run["t_gamma_sum"] = max(wears), sum(wears)

# Weightings: analogue sections in s, each warped at its own frequency.
FINE = 1000.0


def section(numerator, denominator, f):
    """numerator and denominator in ascending powers of s / (2 pi f)."""
    w = 2 * FINE * np.tan(np.pi * f / FINE)
    descending = [[c / w**k for k, c in enumerate(p)][::-1] for p in (numerator, denominator)]
    return descending, [[c / (2 * np.pi * f) ** k for k, c in enumerate(p)][::-1] for p in (numerator, denominator)]


def weighting(f3, q4, step, gain):
    sections = [
        section([0, 0, gain], [1, 2**0.5, 1], 0.4),
        section([1, 0, 0], [1, 2**0.5, 1], 100.0),
        section([1, 1, 0], [1, 1 / q4, 1], f3),
    ]
    if step:
        f5, q5, f6, q6 = step
        sections.append(section([(f5 / f6) ** 2, f5 / f6 / q5, 1], [1, 1 / q6, 1], f6))
    return sections


def sperling(gain):
    # In powers of p = s / (2 pi 1 Hz): roots of the denominator by numpy.
    roots = np.roots([0.0368, 0.277, 1.563, 1.0])
    real = -roots[np.abs(roots.imag) < 1e-9].real[0]
    pair = roots[np.abs(roots.imag) > 1e-9]
    c, b = abs(pair[0]) ** 2, -2 * pair[0].real
    w = c**0.5
    scale = gain / 0.0368 / c
    return [section([0, 1, 0], [1, 1, 0], real), section([scale * 1.911**0.5, scale * 0.25 * w, 0], [1, b / w, 1], w)]


WEIGHTINGS = {
    "Wb": weighting(16.0, 0.55, (2.5, 0.90, 4.0, 0.95), 1.024),
    "Wd": weighting(2.0, 0.63, None, 1.0),
    "Wk": weighting(12.5, 0.63, (2.37, 0.91, 3.35, 0.91), 1.0),
    "lateral": sperling(0.737),
    "vertical": sperling(0.588),
}


def weighted(x, name):
    y = CubicSpline(t, x, bc_type="natural")(np.arange(int(FINE * DURATION) + 1) / FINE)
    exact = np.fft.rfft(y - y.mean())
    f = np.fft.rfftfreq(y.size, 1 / FINE)
    for (numerator, denominator), (above, below) in WEIGHTINGS[name]:
        b, a = signal.bilinear(numerator, denominator, FINE)
        y = signal.lfilter(b, a, y, zi=signal.lfilter_zi(b, a) * y[0])[0]
        exact *= np.polyval(above, 2j * np.pi * f) / np.polyval(below, 2j * np.pi * f)
    # The analogue weighting itself, on the spectrum: what the digital filters and the transient may differ by.
    ratio = np.sqrt(np.mean(y**2)) / np.sqrt(np.mean(np.fft.irfft(exact, y.size) ** 2))
    print(f"{name}: rms {ratio - 1:+.2e} of the analogue weighting", file=sys.stderr)
    assert abs(ratio - 1) < 5e-3
    return y


def rms(x):
    return np.sqrt(np.mean(x**2))


def windows(x):
    n = int(5 * FINE)
    return np.percentile([rms(x[k * n : (k + 1) * n]) for k in range(x.size // n)], 95)


run["n_mv"] = 6 * np.sqrt(windows(weighted(ax, "Wd")) ** 2 + windows(weighted(ay, "Wd")) ** 2 + windows(weighted(az, "Wb")) ** 2)
run["iso_x"], run["iso_y"], run["iso_z"] = rms(weighted(ax, "Wd")), rms(weighted(ay, "Wd")), rms(weighted(az, "Wk"))
run["iso_total"] = np.sqrt(run["iso_x"] ** 2 + run["iso_y"] ** 2 + run["iso_z"] ** 2)
run["wz_y"], run["wz_z"] = [(rms(weighted(a, n)) * 100 * 2**0.5) ** 0.3 for a, n in ((ay, "lateral"), (az, "vertical"))]

json.dump({"straight": {**en14363(250.0), **run}, "curve": en14363(70.0)}, sys.stdout, indent=1)
print()
