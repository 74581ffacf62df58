from .style import use_style

__all__ = [
    "use_style",
]
