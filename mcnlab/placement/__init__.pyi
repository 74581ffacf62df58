from .choice import choose_exact, fewest_for_share
from .comparison import compare_scenes
from .site import choose_cameras, prepare_site
from .votes import place_by_votes

__all__ = [
    "choose_cameras",
    "choose_exact",
    "compare_scenes",
    "fewest_for_share",
    "place_by_votes",
    "prepare_site",
]
