"""A case in a few lines of words, as Python and notebooks print it.

Case -> [rows] -> (what, words) -> text, HTML
"""

from html import escape

from rollerrig.config.schema.case import CaseTables, Contact
from rollerrig.config.schema.support import Rig

ACTING = (
    "adhesion", "brake", "track_brake", "sanding", "traction", "slide_protection", "wheel_slip_control", "brake_unit",
    "rig_control", "axle_torque", "disturbance",
)  # fmt: skip


def rows(case: CaseTables) -> list[tuple[str, str]]:
    """What the case is made of, a row each."""
    vehicle, support, contact, time = case.vehicle, case.support.data, case.contact, case.time
    part = "" if vehicle.cut == "vehicle" else f", {vehicle.cut}"
    bodies = [body.name for body in vehicle.data.bodies_in(vehicle.part)]
    method, step = case.integration
    acting = [name for name in ACTING if getattr(case, name)]
    found = [
        ("vehicle", f"{vehicle.data.name}{part}: {_few(bodies)}"),
        ("support", support.name + (f", rollers of {1e3 * support.roller_radius:g} mm" if isinstance(support, Rig) else "")),
        ("motion", f"{3.6 * case.motion.speed:.4g} km/h at the start, {case.motion.drive.replace('_', ' ')}"),
        ("contact", ", ".join((contact.material.name, f"friction {_friction(contact)}", contact.normal.kind,
                               contact.creep.kind))),
        ("time", f"{time.duration:g} s, kept every {1e3 * time.output_step:g} ms; {method}"
                 + (f", step {1e3 * step:g} ms" if step else "")),
    ]  # fmt: skip
    return [*found, *([("acting", ", ".join(acting))] if acting else [])]


def _few(names: list[str], most: int = 4) -> str:
    return (
        ", ".join(names) if len(names) <= most else f"{', '.join(names[: most - 1])} and {len(names) - most + 1} more"
    )


def _friction(contact: Contact) -> str:
    law, face = contact.friction, contact.gauge_face_friction
    top = f"{law.mu_0:g}" if law.kind == "constant" else law.kind
    return top if face is None else f"{top} ({face:g} on the gauge face)"


def in_words(case: CaseTables) -> str:
    """A headline and a line per row."""
    return "\n".join([_headline(case), *(f"  {what:8} {words}" for what, words in rows(case))])


def in_html(case: CaseTables) -> str:
    """The same as a table."""
    body = "".join(
        f"<tr><th style='text-align:left'>{what}</th><td style='text-align:left'>{escape(words)}</td></tr>"
        for what, words in rows(case)
    )
    return f"<p>{escape(_headline(case))}</p><table>{body}</table>"


def _headline(case: CaseTables) -> str:
    return f"Case {case.name}" + (f": {case.description}" if case.description else "")
