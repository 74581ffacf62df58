"""From phases to one of eight directions (thesis 3.2.1 (e), Figures 3.2, 3.12, 3.13).

Directions are numbered clockwise seen from above, with the camera in the south: 1 away,
2 away-right, 3 right, 4 toward-right, 5 toward, 6 toward-left, 7 left, 8 away-left.
A mirrored walk has the same height and width curves, so a phase alone tells five groups
apart: {1}, {2, 8}, {3, 7}, {4, 6}, {5}.
"""

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.pipeline import Pipeline

from mcnlab.checks import require_array, require_like
from mcnlab.compass import require_directions
from mcnlab.datasets.recording import Recording
from mcnlab.errors import ArgumentError
from mcnlab.regression import fit_lines_robust
from mcnlab.tables import CX, SEQUENCE, H, W, uncut
from mcnlab.walking.phase import relative_growth

GROUPS = (1, 2, 3, 4, 5)
GROUP_NAMES = {1: "1", 2: "2 & 8", 3: "3 & 7", 4: "4 & 6", 5: "5"}
_GROUP_OF = np.array([0, 1, 2, 3, 4, 5, 4, 3, 2])  # by direction


def group_of(directions: ArrayLike) -> np.ndarray | int:
    """The group 1 … 5 that a phase can tell a direction 1 … 8 apart by."""
    return _GROUP_OF[require_directions("directions", directions)]


class LinearSeparators(ClassifierMixin, BaseEstimator):
    """The best-fitting linear separators between groups of phases.

    In the thesis's plot of phase against video (Figures 3.12 and 3.13) a separator is a
    level line.  The groups are ordered by their mean phase, and the lines are placed so
    that as few training videos as possible lie on the wrong side: the exact optimum, by
    dynamic programming over the sorted phases.  Of equally good places the one in the
    widest gap is taken.

    Attributes
    ----------
    classes_ : ndarray
        The groups, sorted.
    order_ : ndarray
        The groups from the lowest phase to the highest.
    cuts_ : ndarray, shape (len(order_) − 1,)
        The separators, in the phase's unit, rising; infinite where a group is squeezed
        out.
    coef_, intercept_ : ndarray
        The same as ``coef_·m + intercept_ = 0``, one row a separator.
    """

    def fit(self, X: ArrayLike, y: ArrayLike) -> "LinearSeparators":
        """Place the separators.

        Parameters
        ----------
        X : array_like, shape (n,) or (n, 1)
            Phases.
        y : array_like, shape (n,)
            Groups.
        """
        phase, y = _as_phases(X, least=1), np.asarray(y)
        require_like(phase, of="X", y=y)
        self.classes_, codes = np.unique(y, return_inverse=True)
        count = len(self.classes_)
        means = np.bincount(codes, phase) / np.bincount(codes)
        ranks = np.argsort(means, kind="stable")
        self.order_ = self.classes_[ranks]
        values, places = np.unique(phase, return_inverse=True)
        # hits[i, k]: videos of the k-th group among the i lowest phases
        hits = np.zeros((len(values) + 1, count))
        np.add.at(hits, (places + 1, np.argsort(ranks)[codes]), 1)
        hits = hits.cumsum(axis=0)
        gap = np.r_[0.0, np.diff(values), 0.0]
        bonus = gap / (gap.max() + 1e-300) / (2 * count)  # all bonuses together: under one video
        best = np.where(np.arange(len(values) + 1) == 0, 0.0, -np.inf)
        before = []
        for k in range(count):
            start = best + (bonus if k else 0.0) - hits[:, k]
            # The best start of this group's stretch at or before each place.
            reach = np.maximum.accumulate(start)
            at = np.where(start == reach, np.arange(len(start)), 0)
            before.append(np.maximum.accumulate(at))
            best = hits[:, k] + reach
        place, cuts = len(values), []
        for k in range(count - 1, 0, -1):
            place = before[k][place]
            cuts.append(place)
        middles = np.r_[-np.inf, (values[1:] + values[:-1]) / 2, np.inf]
        self.cuts_ = middles[np.array(cuts[::-1], dtype=int)]
        self.coef_ = np.ones((count - 1, 1))
        self.intercept_ = -self.cuts_
        self.n_features_in_ = 1
        return self

    def predict(self, X: ArrayLike) -> np.ndarray:
        """The group of each phase."""
        return self.order_[np.searchsorted(self.cuts_, _as_phases(X))]


def leave_one_subject_out(
    estimator: BaseEstimator, X: ArrayLike, y: ArrayLike, subjects: ArrayLike
) -> np.ndarray:
    """What `estimator` says of each subject's walks, having learned from the others.

    Parameters
    ----------
    estimator : scikit-learn classifier
    X : array_like, shape (n,) or (n, k)
    y : array_like, shape (n,)
    subjects : array_like, shape (n,)

    Returns
    -------
    ndarray, shape (n,)
        Predictions.

    Raises
    ------
    ArgumentError
        When there are fewer than two subjects.
    """
    from sklearn.model_selection import LeaveOneGroupOut, cross_val_predict

    X, y, subjects = np.asarray(X), np.asarray(y), np.asarray(subjects)
    require_like(y, of="y", subjects=subjects, X=X[:, 0] if X.ndim == 2 else X)
    if len(np.unique(subjects)) < 2:
        raise ArgumentError("subjects names one subject only; leaving one out needs two.")
    return cross_val_predict(estimator, X, y, groups=subjects, cv=LeaveOneGroupOut())


def measure_phase_space(recording: Recording) -> pd.DataFrame:
    """Several distance-invariant phases of every walk.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    pandas.DataFrame
        Indexed by sequence: ``height_growth`` and ``width_growth`` (relative growth,
        1/s) and ``sideways`` (the centroid's motion to the right, body heights a second).

    Raises
    ------
    McnError
        When the table is not sound or a walk has no two frames.

    Examples
    --------
    >>> from mcnlab import vision, walking
    >>> space = walking.measure_phase_space(vision.casia_a())
    >>> space.loc[["fyc-00_1", "fyc-45_1"]].reset_index().round(2)
       sequence  height_growth  width_growth  sideways
    0  fyc-00_1          -0.01          0.03     -0.77
    1  fyc-45_1           0.12          0.16     -0.53
    """
    stack = recording.stack
    time = np.arange(stack.valid.shape[1]) / recording.frame_rate
    weights = uncut(stack, recording.frame_width, recording.frame_height).astype(float)
    height, width = stack.curves[H], stack.curves[W]
    safe_h, safe_w = np.where(stack.valid, height, 1.0), np.where(stack.valid, width, 1.0)

    mean_height = (weights * height).sum(axis=1) / weights.sum(axis=1)
    drift = fit_lines_robust(time, stack.curves[CX], weights=weights)[0].slope
    features = {
        "height_growth": relative_growth(time, safe_h, weights=weights),
        "width_growth": relative_growth(time, safe_w, weights=weights),
        "sideways": drift / mean_height,
    }
    return pd.DataFrame(features, index=pd.Index(stack.names, name=SEQUENCE))


def phase_space_classifier() -> Pipeline:
    """Linear separators over several phases: linear discriminant analysis, scaled."""
    from sklearn.discriminant_analysis import LinearDiscriminantAnalysis
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    return make_pipeline(StandardScaler(), LinearDiscriminantAnalysis())


def _as_phases(values, least=0):
    values = np.asarray(values)
    if values.ndim == 2 and values.shape[1] == 1:
        values = values[:, 0]
    return require_array("X", values, (None,), least=least, remedy="one finite phase a video")
