"""Where does a wheelset touch its rails near the middle, and what does the choice of the contact model change there?"""

import rollerrig as rr

lateral = [-2e-3, -1e-3, 0.0, 1e-3, 2e-3]  # m
for normal in ("hertz", "strips"):
    case = rr.load_case("contact_benchmark_track").with_changes({"contact.normal": normal})
    table = rr.contact(case, [(y, 0.0) for y in lateral])
    left = table.sel(row=table["side"] == "left")
    for y in lateral:
        here = left.sel(row=abs(left["lateral"] - y) < 1e-9)
        patches = ", ".join(
            f"S = {1e3 * float(s):+.1f} mm with {1e-3 * float(n):.1f} kN"
            for s, n in zip(here["wheel_abscissa"], here["normal"], strict=True)
        )
        print(f"{normal}, {1e3 * y:+.0f} mm: {patches}")
rr.plot.contact_figure(table).savefig("contact.png")
