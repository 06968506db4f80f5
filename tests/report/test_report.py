"""The report page: held against its input in a real browser, number by number and point by point."""
import os
import pathlib
import sys
import unittest

SYSTEM = "/usr/bin/python3"
if __name__ == "__main__" and os.path.exists(SYSTEM) and not os.environ.get("VCD_REPORT_TEST"):
    os.environ["VCD_REPORT_TEST"] = "1"  # another Python may lack the packages that the system's has
    os.execv(SYSTEM, [SYSTEM, *sys.argv])

HERE = pathlib.Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "tools" / "lab" / "report")]
import report_case  # noqa: E402
from dominance_case import Dominance  # noqa: E402, F401
from files_case import Files  # noqa: E402, F401
from paths_case import Paths  # noqa: E402, F401
from refusals_case import Refusals  # noqa: E402, F401
from stability_case import Stability  # noqa: E402, F401

if report_case.BROWSER:
    from figures_case import Figures  # noqa: F401
    from page_case import Page  # noqa: F401
    from stability_page_case import StabilityPage  # noqa: F401

if __name__ == "__main__":
    if not report_case.matplotlib:
        print("skipped:", report_case.WHY, file=sys.stderr)
    elif not report_case.BROWSER:
        print("skipped, the page in a browser:", report_case.WHY_BROWSER, file=sys.stderr)
    unittest.main()
