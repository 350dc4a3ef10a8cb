"""How reports write numbers, tables, and whether a paper's conclusion holds."""


def ms(value):
    return f"{value:.3f}" if value < 10 else f"{value:.1f}"


def ratio(value):
    return f"{value:.2f}"


def percent(value):
    return (
        f"{100 * value:.0f} %"
        if value >= 0.1
        else f"{100 * value:.1f} %"
        if value >= 0.001
        else f"{100 * value:.2g} %"
    )


def rows_of(head, rows):
    yield "| " + " | ".join(head) + " |"
    yield "|" + "---|" * len(head)
    for row in rows:
        yield "| " + " | ".join(str(cell) for cell in row) + " |"


def verdict(claim, holds, evidence, why=""):
    yield f"- **{'Agrees' if holds else 'Does not agree'}.** {claim} {evidence}" + (
        f" {why}" if why and not holds else ""
    )
