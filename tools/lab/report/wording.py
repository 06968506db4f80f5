"""Names that several parts of the page share."""

KINDS = {
    "missing": "passes the box by", "piercing": "through the box, both ends outside", "own": "from the object itself",
    "inside": "from elsewhere inside the box", "instanced-ground": "many instances, from the ground",
    "instanced-own": "many instances, from an object"}
METHODS = {"proven": "proven", "hybrid": "hybrid", "sampled": "sampled", "hierarchy": "hierarchy",
           "embree": "Embree", "embree_robust": "Embree robust"}
VIEWS = {"shaded": "shaded", "tests": "ray-triangle tests", "fallback": "rays that needed the BVH",
         "difference": "difference from the BVH"}
NOT_RUN = "not run"
