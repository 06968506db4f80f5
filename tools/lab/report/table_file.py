"""report.csv: one row a scene × variant, every figure, unrounded; empty where not measured."""
import csv
import io

KIND = ("segments", "ns", "lookup_ns", "embree_ns", "ratio", "resolved_share", "wrong", "wrong_rate", "wrong_bound_95",
        "wrong_resolved", "wrong_resolved_rate", "wrong_resolved_bound_95")
IMAGE_KIND = ("segments", "resolved", "blocked", "clear", "wrong", "wrong_bound_95")


def csv_text(scenes):
    kinds = list(dict.fromkeys(r["kind"] for s in scenes for r in s["kinds"]))
    image_kinds = list(dict.fromkeys(r["kind"] for s in scenes for r in s["image_kinds"]))
    columns, rows = ["scene", "id", "label"], []
    for scene in scenes:
        for variant in scene["variants"]:
            row = dict(variant)
            for prefix, list_, keys in (("timed", scene["kinds"], KIND), ("image", scene["image_kinds"], IMAGE_KIND)):
                for r in (r for r in list_ if r["id"] == variant["id"]):
                    row.update({f"{prefix}_{r['kind']}_{k}": r[k] for k in keys})
            columns = list(dict.fromkeys([*columns, *variant]))
            rows.append(row)
    columns += [f"timed_{kind}_{k}" for kind in kinds for k in KIND] + [f"image_{kind}_{k}" for kind in image_kinds for k in IMAGE_KIND]
    out = io.StringIO()
    writer = csv.DictWriter(out, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: "" if v is None else v for k, v in row.items()} for row in rows)
    return out.getvalue()
