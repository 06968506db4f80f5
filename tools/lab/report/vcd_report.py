#!/usr/bin/env python3
"""The report page of a vc-bench run.

    vcd_report.py DIR     DIR/results.json, its images and, where it is there, DIR/stability.json
                          → DIR/report.html, report.csv, report.json and charts/*.svg

Needs matplotlib, nothing else. Exit codes: 0 ok, 1 usage, 2 a file cannot be read or written, 3 results.json, stability.json
or an image is not valid, 4 matplotlib is missing. On failure nothing is replaced.
"""
import contextlib
import json
import os
import pathlib
import sys

sys.dont_write_bytecode = True  # the scripts may lie in a folder that belongs to the system

from results import IO, ReportError, load, parse  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
NO_MATPLOTLIB = 4


def make(folder):
    """{relative path: text} of every output, all in memory, so that an error leaves an earlier report whole."""
    import canvas, chart_data, dominance, figures, lanes, page, paper_tables, pictures, scatter, stability_charts, stability_data, stability_part
    import table_file, tables, trends

    results, paper, remarks = load(folder), parse(HERE / "paper.json"), {}
    if (HERE / "remarks.json").exists():
        remarks = parse(HERE / "remarks.json")
    stability = stability_data.figures_of(folder)
    scenes = [figures.scene_figures(s) for s in results["scenes"]]
    drawn, short = chart_data.all_charts(scenes), figures.short_setting(results)
    depths = sorted({p["depth"] for c in drawn for p in c["points"]} - {None})
    speedups = [c for c in drawn if c["chart"] == "speedup"]
    sweeps = stability_charts.charts(stability)
    dominances = dominance.all_scenes(scenes)
    report = {
        "tool": "vc-bench", "version": results.get("version"), "command": results.get("command"), "format": 1,
        "settings": results.get("settings", {}), "machine": results.get("machine", {}), "short": short, "scenes": scenes,
        "dominance": dominances, "charts": drawn, "own_speedup_axes": bool(speedups) and not scatter.shares_y(speedups),
        "tables": tables.all_tables(scenes) + dominance.tables(dominances) + paper_tables.paper_tables(scenes, paper) +
        stability_data.tables(stability), "paper_source": paper["source"],
        "trends": trends.all_trends(scenes, paper, remarks), "stability": stability and {**stability, "charts": sweeps}}
    charts, files = [], {}
    for data in drawn:
        way = lanes if data["chart"] == "kinds" else scatter
        group = [c for c in drawn if c["chart"] == data["chart"]]
        picture, marks = way.draw(data, group, depths)
        charts.append(finished(data, picture, marks, way))
        files[f"charts/{data['id']}.svg"] = canvas.standalone(charts[-1]["svg"], picture.width, picture.height, short)
    hard = []
    for data in sweeps:
        picture, marks = stability_charts.draw(data, sweeps)
        hard.append(finished(data, picture, marks, stability_charts))
        files[f"charts/{data['id']}.svg"] = canvas.standalone(hard[-1]["svg"], picture.width, picture.height, stability_part.short(stability))
    compares = [pictures.compare(s, pictures.collect(folder, s), short) for s in results["scenes"]]
    files["report.csv"] = table_file.csv_text(scenes)
    files["report.json"] = json.dumps(report, indent=1, ensure_ascii=False) + "\n"
    files["report.html"] = page.build(report, charts, hard, compares)  # last: whoever sees the page finds the rest
    return files


def finished(data, picture, marks, way):
    """A drawn chart as the page takes it."""
    import page

    svg = picture.finish(data["id"], f"{data['title']}: {page.CHART_TITLES[data['chart']]}", way.describe(data), marks,
                         {"data-x-scale": data["x_scale"], "data-y-scale": data["y_scale"]})
    return {"data": data, "svg": svg, "says": way.says(data)}


def write(folder, files):
    """Every file under a temporary name first; only when all are on the disk are they renamed."""
    waiting, path = [], folder
    try:
        (folder / "charts").mkdir(exist_ok=True)
        for path in (folder / name for name in files):
            if path.is_dir():
                raise IsADirectoryError(0, "it is a folder")
        for name, text in files.items():
            path = folder / name
            temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
            waiting.append((temporary, path))
            with open(temporary, "w", encoding="utf-8", newline="\n") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
        while waiting:
            temporary, path = waiting[0]
            os.replace(temporary, path)
            waiting.pop(0)
    except OSError as error:
        raise ReportError(IO, f"{path}: cannot be written: {error.strerror}") from error
    finally:
        for temporary, _ in waiting:
            with contextlib.suppress(OSError):  # it may never have been made
                temporary.unlink()


def main(arguments):
    if arguments in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0
    if len(arguments) != 1 or arguments[0].startswith("-"):
        print("usage: vcd_report.py DIR", file=sys.stderr)
        return 1
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        print(f"vcd_report.py: {sys.executable} cannot load matplotlib ({error}); on Debian it is in python3-matplotlib",
              file=sys.stderr)
        return NO_MATPLOTLIB
    folder = pathlib.Path(arguments[0])
    try:
        write(folder, make(folder))
    except ReportError as error:
        print(f"vcd_report.py: {error}", file=sys.stderr)
        return error.code
    print(folder / "report.html")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
