"""Pieces of SVG charts for the scripts beside this one: axes, lines, marks, numbers as text."""
import math

INK, GRID, SOFT = "#222", "#dcdcdc", "#666"


def decades(values):
    """Whole powers of ten around the values."""
    return math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))


class Axis:
    def __init__(self, low, high, start, end):
        self.low, self.high, self.start, self.end = low, high, start, end

    def __call__(self, value):
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def ticks(self):
        for power in range(self.low, self.high + 1):
            yield 10.0**power, True
            if power < self.high:
                for k in range(2, 10):
                    yield k * 10.0**power, False


def count_text(value):
    return f"{value:,.0f}".replace(",", " ")


def time_text(ms):
    if ms >= 1000:
        return f"{ms / 1000:g} s"
    return f"{ms:g} ms" if ms >= 1 else f"{ms * 1000:g} µs"


def text(x, y, words, anchor="start", size=13, colour=INK, more=""):
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" '
        f'fill="{colour}"{more}>{words}</text>'
    )


def line(x1, y1, x2, y2, colour, width=1.0, more=""):
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
        f'stroke-width="{width}"{more}/>'
    )


def path(points, colour, dashes=""):
    corners = " ".join(f"{px:.1f},{py:.1f}" for px, py in points)
    return f'<polyline points="{corners}" fill="none" stroke="{colour}" stroke-width="2"{dashes}/>'


def mark(shape, x, y, colour, size=4.0, hollow=False):
    """A circle, square, diamond or triangle of about the same weight."""
    paint = f'fill="{"white" if hollow else colour}" stroke="{colour}" stroke-width="1.4"'
    if shape == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{size}" {paint}/>'
    across, up = {
        "square": ((-0.9, 0.9, 0.9, -0.9), (-0.9, -0.9, 0.9, 0.9)),
        "diamond": ((0, 1.3, 0, -1.3), (-1.3, 0, 1.3, 0)),
        "triangle": ((0, 1.15, -1.15), (-1.2, 0.9, 0.9)),
    }[shape]
    corners = " ".join(f"{x + size * dx:.1f},{y + size * dy:.1f}" for dx, dy in zip(across, up))
    return f'<polygon points="{corners}" {paint}/>'
