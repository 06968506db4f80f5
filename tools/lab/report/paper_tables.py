"""Tables 1 and 2 of the paper, each figure beside the one measured here."""
from figures import MIB, SINGLE, is_configuration, is_sampled
from tables import column

PAIRS = [  # key here, key in the paper, factor from ours to the paper's unit, heading, format here
    ("render_seconds", "render_seconds", "Render time, s", "seconds"), ("tests", "tests_millions", "Tests, millions", "millions"),
    ("memory_bytes", "memory_mib", "Memory, MiB", "mib"), ("bake_seconds", "build_seconds", "Build time, s", "seconds"),
    ("wrong_rate", "error_percent", "Wrong rays", "percent")]
UNIT = {"tests_millions": 1e6, "memory_mib": MIB, "error_percent": 0.01, "uncompressed_mib": MIB, "compressed_mib": MIB}
OF_BVH = {"render_seconds": "render_ratio", "tests": "tests_ratio"}


def in_our_unit(entry, key):
    return None if entry is None or key not in entry else round(entry[key] * UNIT.get(key, 1), 12)


def table1(scenes, paper):
    """At depth 7 with 256 samples, as there; where that was not run, the deepest that was, and the table says which."""
    columns = [column("configuration", "Measured at", "text"),
               column("here_unfolded", "Uncompressed", "mib", "here, MiB"), column("here_folded", "folded leaves", "mib", "here, MiB"),
               column("here_shared", "compressed", "mib", "here, MiB"), column("here_factor", "factor", "ratio", "here, MiB"),
               column("paper_uncompressed", "Uncompressed", "mib", "paper, MiB"),
               column("paper_compressed", "compressed", "mib", "paper, MiB"), column("paper_factor", "factor", "ratio", "paper, MiB")]
    rows = []
    for scene in scenes:
        run = [r for r in scene["variants"] if is_sampled(r) and r["shared_bytes"] is not None]
        row = max(run, key=lambda r: (r["depth"], r["samples"]), default={})
        row = next((r for r in run if r["id"] == "d7-n256"), row)
        entry = paper["table1"].get(scene["name"])
        unfolded, shared = row.get("unfolded_bytes"), row.get("shared_bytes")
        there, folded_there = in_our_unit(entry, "uncompressed_mib"), in_our_unit(entry, "compressed_mib")
        rows.append({"id": scene["name"], "label": scene["title"], "configuration": row.get("label"),
                     "here_unfolded": unfolded, "here_folded": row.get("folded_bytes"), "here_shared": shared,
                     "here_factor": unfolded / shared if unfolded and shared else None,
                     "paper_uncompressed": there, "paper_compressed": folded_there,
                     "paper_factor": there / folded_there if entry else None})
    return {"id": "paper-1", "caption": "Table 1: the tree without and with compression", "head": "Scene", "columns": columns,
            "sections": [{"scene": None, "title": None, "error": None, "rows": rows}]}


def table2(scene, paper):
    """One scene's part of Table 2. Ratios to the BVH compare better across machines than seconds do."""
    entries = paper["table2"].get(scene["name"], {})
    columns, rows = [], []
    for ours, theirs, heading, kind in PAIRS:
        columns += [column(f"here_{ours}", "here", kind, heading), column(f"paper_{ours}", "paper", kind, heading)]
        if ours in OF_BVH:
            group = heading.split(",")[0] + ", of the BVH's"
            columns += [column(f"here_{OF_BVH[ours]}", "here", "ratio", group), column(f"paper_{OF_BVH[ours]}", "paper", "ratio", group)]
    for row in scene["variants"]:
        if row["id"] not in ("bvh", SINGLE) and not is_configuration(row):
            continue
        entry, made = entries.get(row["id"]), {"id": row["id"], "label": row["label"]}
        for ours, theirs, _, _ in PAIRS:
            exact = ours == "wrong_rate" and row["id"] == "bvh"
            made[f"here_{ours}"] = 0 if exact else row[ours]
            made[f"paper_{ours}"] = 0 if exact and entry else in_our_unit(entry, theirs)
            if ours in OF_BVH:
                made[f"here_{OF_BVH[ours]}"] = row[OF_BVH[ours]]
                made[f"paper_{OF_BVH[ours]}"] = entry[theirs] / entries["bvh"][theirs] if entry else None
        rows.append(made)
    return {"id": f"paper-2-{scene['name']}", "caption": f"Table 2: {scene['title']}", "head": "Configuration", "columns": columns,
            "sections": [{"scene": scene["name"], "title": None, "error": scene["error"], "rows": rows}]}


def paper_tables(scenes, paper):
    return [table1(scenes, paper)] + [table2(scene, paper) for scene in scenes]
