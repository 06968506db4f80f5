"""Value → pixel, and ticks. Three scales: linear, log, and rate: a log scale with a place of its own for zero."""
import math

from figures import MIB
from formats import SUPERSCRIPT, power_of_ten, round_number

SLOT = 47  # pixels that a rate axis keeps for "0 seen": lanes of six methods side by side


def decades(low, high):
    return [10.0 ** e for e in range(math.floor(math.log10(low) + 1e-9), math.ceil(math.log10(high) - 1e-9) + 1)]


def rate_text(value):
    """A share, written in per cent as far as one can read the zeros."""
    percent = value * 100
    if percent >= 9.99e-4:
        return f"{percent:.12f}".rstrip("0").rstrip(".") + " %"
    return f"10{str(round(math.log10(percent))).translate(SUPERSCRIPT)} %"


class Axis:
    def __init__(self, scale, values, start, end, unit="", tight=False):
        """values: all that must be inside. start, end: pixels; end may be the smaller (y axes). tight: a linear axis may end at
        a value."""
        self.scale, self.start, self.end, self.unit = scale, start, end, unit
        self.direction = 1 if end > start else -1
        if scale == "linear":
            self.ticks = linear_ticks(min(values), max(values), tight)
            self.low, self.high = self.ticks[0], self.ticks[-1]
        else:
            positive = [v for v in values if v > 0] or [1e-6, 1e-5]
            self.ticks = decades(min(positive), max(positive))
            self.low, self.high = self.ticks[0], self.ticks[-1]
            if scale == "log":
                self.tighten(positive)
            if self.low == self.high:
                self.high *= 10
                self.ticks.append(self.high)

    def tighten(self, positive):
        """A log axis ends at 1, 2 or 5 times a power of ten, so that small spans fill it; few decades get more ticks."""
        fine = [m * d for d in decades(min(positive) / 10, max(positive)) for m in (1, 2, 5)]
        self.low = max([f for f in fine if f <= min(positive) * 0.93] or [fine[0]])
        self.high = min([f for f in fine if f >= max(positive) * 1.07] or [fine[-1]])
        inside = [f for f in fine if self.low * 0.999 <= f <= self.high * 1.001]
        tens = [f for f in inside if power_of_ten(f) is not None]
        step = next(s for s in (1, 2, 5, 10, 20, 50, 100, 1000) if len(tens) <= 9 * s)
        self.ticks = inside if len(inside) <= 6 else [f for f in tens if power_of_ten(f) % step == 0]

    def zero(self, lane=0, lanes=1):
        """Where zeros are drawn: the middle of the slot, or of one of the lanes that share it."""
        return self.start + self.direction * (SLOT - 6) * (lane + 0.5) / lanes

    def __call__(self, value, lane=0, lanes=1):
        """lane: of zeros on a rate axis."""
        if self.scale == "rate" and value <= 0:
            return self.zero(lane, lanes)
        first = self.start + self.direction * (SLOT if self.scale == "rate" else 0)
        if self.scale == "linear":
            share = (value - self.low) / (self.high - self.low)
        else:
            share = math.log(value / self.low) / math.log(self.high / self.low)
        return first + share * (self.end - first)

    def labelled(self, gap):
        """Of the ticks those, from the far end, whose texts keep that many pixels to the next and to that of zero."""
        kept = []
        for tick in reversed(self.ticks):
            others = [self(t) for t in kept] + ([self.zero()] if self.scale == "rate" else [])
            if all(abs(self(tick) - other) >= gap for other in others):
                kept.append(tick)
        return kept

    def tick_text(self, value):
        if self.scale == "rate":
            return rate_text(value)
        if self.unit == "bytes":
            return f"{value:g}"
        if self.unit == "power":
            return round_number(value)
        if self.unit == "share":
            return f"{value * 100:g} %"
        if self.unit == "times":
            return f"{value:g}×"
        return f"{value:,.0f}".replace(",", "\u202f") if value >= 10000 else f"{value:g}"


def linear_ticks(low, high, tight=False):
    """Four to seven round ticks that enclose the values; tight: or end at them."""
    span = high - low or abs(high) or 1
    step = 10 ** math.floor(math.log10(span / 4))
    step = next(step * m for m in (1, 2, 2.5, 5, 10) if span / (step * m) <= 5)
    room = -1e-9 if tight else 1e-9
    first, last = math.floor(low / step - room), math.ceil(high / step + room)
    return [round(step * i, 12) for i in range(first, last + 1)]


def tick_mark(axis, value):
    """What the page says of a tick's label, so that a test can hold the scale against the points."""
    return {"class": "tick", "data": {"axis": axis, "v": value}, "tip": None}


def scaled(value, unit):
    """Axes of memory count in MiB."""
    return value / MIB if unit == "bytes" and value is not None else value
