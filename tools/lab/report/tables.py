"""The tables of the page as data: columns with their formats, rows in one section a scene."""
from figures import USES, is_configuration, is_hierarchy


def column(key, label, kind, group=None):
    return {"key": key, "label": label, "format": kind, "group": group}


def table(name, caption, head, columns, sections):
    """head: what the rows are. Rows carry only what the columns show."""
    keys = [c["key"] for c in columns]
    return {"id": name, "caption": caption, "head": head, "columns": columns,
            "sections": [{"scene": s["name"], "title": s["title"], "error": s["error"],
                          "rows": [{"id": r["id"], "label": r["label"], **{k: r.get(k) for k in keys}} for r in rows]}
                         for s, rows in sections]}


def configurations(scene):
    return [r for r in scene["variants"] if is_configuration(r)]


def scenes_table(scenes):
    columns = [column("status", "State", "text"), column("source", "Source", "text"), column("triangles", "Triangles", "count"),
               column("instances", "Instances", "count"), column("placed_triangles", "Triangles placed", "count"),
               column("lights", "Lights", "count"), column("judge", "Judged by", "text"), column("shadow_segments", "Shadow rays an image", "count"),
               column("bvh_build_seconds", "BVH build, s", "seconds"), column("bvh_memory_bytes", "BVH memory, MiB", "mib"),
               column("packets_bvh", "Embree's way, BVH", "text"), column("packets_vcd", "Embree's way, fallback", "text")]
    return {"id": "scenes", "caption": "The scenes", "head": "Scene", "columns": columns, "sections": [
        {"scene": None, "title": None, "error": None, "rows": [
            {"id": s["name"], "label": s["title"], **{c["key"]: s[c["key"]] for c in columns}} for s in scenes]}]}


def speedup_table(scenes):
    return table("speedup", "Speed-up against wrong rays", "Configuration", [
        column("speedup", "Speed-up", "ratio"), column("speedup_low", "lowest", "ratio"), column("speedup_high", "highest", "ratio"),
        column("shadow_seconds", "Shadow rays, s", "seconds"), column("render_seconds", "Whole image, s", "seconds"),
        column("wrong", "Wrong rays", "count"), column("wrong_rate", "Wrong", "percent"),
        column("wrong_bound_95", "95 % bound", "percent"), column("memory_bytes", "Memory, MiB", "mib"),
        column("rmse", "RMSE", "number"), column("max_difference", "Largest difference", "number")],
        [(s, [r for r in s["variants"] if r["id"] == "bvh" or is_configuration(r) or is_hierarchy(r)]) for s in scenes])


def bake_table(scenes):
    return table("bake", "Bake time against wrong rays", "Configuration", [
        column("bake_seconds", "Bake, s", "seconds"), column("bake_rays", "Rays cast", "count"),
        column("wrong_rate", "Wrong", "percent"), column("wrong_bound_95", "95 % bound", "percent")],
        [(s, configurations(s)) for s in scenes])


def memory_table(scenes):
    return table("memory", "Memory against rays answered", "Configuration", [
        column("memory_bytes", "Memory, MiB", "mib"), column("file_bytes", "File, MiB", "mib"),
        column("ship_bytes", "Compressed file, MiB", "mib"), column("hierarchy_bytes_a_triangle", "Hierarchy, bytes a triangle", "number"),
        column("horizon_bytes_a_triangle", "Horizons, bytes a triangle", "number"), column("segments", "Shadow rays", "count"),
        column("resolved_share", "Answered without the BVH", "percent"), column("fallback_segments", "Needed the BVH", "count")],
        [(s, configurations(s)) for s in scenes])


COUNTED = [column("resolved_share", "Answered", "percent"), column("blocked", "blocked", "count"), column("clear", "clear", "count"),
           column("wrong", "Wrong", "count", "of all"), column("wrong_rate", "share", "percent", "of all"),
           column("wrong_bound_95", "95 % bound", "percent", "of all"),
           column("wrong_resolved", "Wrong", "count", "of those answered"),
           column("wrong_resolved_rate", "share", "percent", "of those answered"),
           column("wrong_resolved_bound_95", "95 % bound", "percent", "of those answered")]


def by_kind(rows):
    ordered = []
    for kind in dict.fromkeys(r["kind"] for r in rows):
        ordered += [{**r, "id": f"{r['id']}-{kind}"} for r in rows if r["kind"] == kind]
    return ordered


def kinds_table(scenes):
    return table("kinds", "Time and answers by kind of segment", "Configuration", [
        column("kind", "Kind", "text"), column("segments", "Segments", "count"),
        column("embree_ns", "Embree", "ns", "ns a segment"), column("lookup_ns", "look-up", "ns", "ns a segment"),
        column("ns", "with fallback", "ns", "ns a segment"), column("ratio", "of Embree's fastest", "ratio", "Embree ÷ ours"),
        column("hierarchy_ns", "own hierarchy", "ns", "ns a segment"), *COUNTED],
        [(s, by_kind(s["kinds"])) for s in scenes])


WAYS = [(f"rtcOccluded{width}{flag}", label) for width in (1, 8, 16) for flag, label in (("", "plain"), (", coherent", "coherent"))]


def ways_table(scenes):
    return table("ways", "Embree’s ways, nanoseconds a segment", "Kind", [
        column("segments", "Segments", "count"), *(column(name, label, "ns", name.split(",")[0]) for name, label in WAYS),
        column("best", "Fastest", "text")], [(s, s["ways"]) for s in scenes])


def image_kinds_table(scenes):
    return table("image-kinds", "All shadow rays of one image by kind", "Configuration", [
        column("kind", "Kind", "text"), column("segments", "Segments", "count"), *COUNTED],
        [(s, by_kind(s["image_kinds"])) for s in scenes])


def path_table(use, caption):
    def make(scenes):
        return table(use, caption, "Configuration", [
            column("segments", "Shadow rays", "count"), column("ns", "ns a ray", "ns"), column("embree_ns", "Embree's fastest, ns", "ns"),
            column("embree", "Embree's fastest", "text"), column("speedup", "Speed-up", "ratio"), column("speedup_low", "lowest", "ratio"),
            column("speedup_high", "highest", "ratio"), column("judged", "Judged", "count"), column("wrong", "Wrong", "count"),
            column("wrong_rate", "Wrong", "percent"), column("wrong_bound_95", "95 % bound", "percent")],
            [(s, s[use]) for s in scenes])
    return make


PATH_TABLES = [path_table(use, caption) for use, caption in zip(USES, ("Path tracer, single calls", "Path tracer, wavefronts of 4,096 paths"))]


def unclassified_table(scenes):
    return table("unclassified", "Every cell unclassified: what the look-up itself costs", "Variant", [
        column("shadow_seconds", "Shadow rays, s", "seconds"), column("shadow_ratio", "of the BVH's time", "ratio"),
        column("shadow_ratio_low", "lowest", "ratio"), column("shadow_ratio_high", "highest", "ratio"),
        column("render_ratio", "Whole image, of the BVH's time", "ratio"), column("identical_image", "Image identical", "flag")],
        [(s, [r for r in s["variants"] if r["id"] == "unclassified"]) for s in scenes])


def all_tables(scenes):
    return [make(scenes) for make in (scenes_table, speedup_table, bake_table, memory_table, kinds_table, ways_table, image_kinds_table, *PATH_TABLES, unclassified_table)]
