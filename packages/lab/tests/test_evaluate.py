import numpy as np
import pytest

from sunset.calibration import roc_auc
from sunset.metrics import count_classes, image_iou
from sunset.perception import Modality, Segmenter, load_model
from sunset_lab import FrameSet
from sunset_lab.frames import FrameSets
from sunset_lab.measuring import measure

pytestmark = pytest.mark.thorough


def test_a_measurement_is_that_of_each_frame(sets: FrameSets) -> None:
    few = FrameSet(sets.test.bgr[:3], sets.test.depth[:3], sets.test.labels[:3])
    segmenter = Segmenter(load_model("lite"))
    measured = measure(segmenter.model, few, range(3), jobs=1)
    results = [segmenter.segment(Modality.FUSION, few.bgr[i], few.depth[i]) for i in range(3)]
    counts = [count_classes(result.labels, few.labels[i]) for i, result in enumerate(results)]
    assert measured.per_image()[0] == pytest.approx(np.mean([image_iou(count) for count in counts]))
    assert measured.counts[:, 0, 2].sum() == 3 * 144 * 256
    assert set(np.flatnonzero(~np.isnan(measured.by_class()[0]))) >= set(np.unique(few.labels).tolist())


@pytest.mark.parametrize(("positive", "expected"), [([3.0, 4.0], 1.0), ([0.0], 0.0), ([1.0, 2.0], 0.5)])
def test_auc_counts_pairs_and_half_of_ties(positive: list[float], expected: float) -> None:
    assert roc_auc(np.array([1.0, 2.0]), np.array(positive)) == expected
