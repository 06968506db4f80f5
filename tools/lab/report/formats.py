"""Figures as people read them. The exact value stands beside it in the page (data-v), in report.json and report.csv."""
import math

from figures import MIB

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
THIN = "\u202f"


def significant(value, digits=3):
    """Three digits that count; long numbers whole, in groups of three; tiny ones as a power of ten."""
    if value == 0:
        return "0"
    size = math.floor(math.log10(abs(value)))
    if size >= digits:
        return whole(value)
    if size < -4:
        return f"{value / 10.0 ** size:.{digits - 1}f}×10{str(size).translate(SUPERSCRIPT)}"
    return f"{value:.{max(0, digits - 1 - size)}f}"


def whole(value):
    return f"{round(value):,}".replace(",", THIN)


def power_of_ten(value):
    """Its exponent, or None."""
    exponent = round(math.log10(value)) if value > 0 else None
    return exponent if exponent is not None and math.isclose(value, 10.0 ** exponent, rel_tol=1e-9) else None


def round_number(value):
    """Parameters that may span sixty decades: as they are, or as powers of ten."""
    exponent = power_of_ten(value)
    return f"{value:g}" if exponent is None or abs(exponent) < 4 else f"10{str(exponent).translate(SUPERSCRIPT)}"


FORMATS = {
    "text": str, "count": whole, "number": significant, "seconds": significant, "ns": significant,
    "ratio": lambda v: significant(v) + "×", "percent": lambda v: significant(v * 100) + "\u00a0%",
    "mib": lambda v: significant(v / MIB), "millions": lambda v: significant(v / 1e6, 4),
    "flag": lambda v: "yes" if v else "no"}


def show(value, kind):
    return FORMATS[kind](value)
