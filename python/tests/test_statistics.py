"""Expected values: scipy.stats.nct 1.16 for the distribution, closed forms for the rest."""

import math
import random
import unittest

from microsim import compare, cusum
from microsim.statistics import noncentral_t


class NoncentralT(unittest.TestCase):
    def test_values_of_scipy(self) -> None:
        for t, freedom, noncentrality, expected in [
            (2.0, 10, 0.0, 0.9633059826146299),
            (2.0, 10, 1.0, 0.8076115625303752),
            (-1.0, 3, 0.5, 0.09212120981435942),
            (5.0, 2, 3.0, 0.6894905962120523),
            (1.5, 200, 1.0, 0.6903103363659707),
        ]:
            self.assertAlmostEqual(noncentral_t(t, freedom, noncentrality), expected, delta=1e-12)

    def test_of_two_degrees_it_is_elementary(self) -> None:
        # Student's t with ν = 2 has F(t) = 1/2 + t / (2 √(2 + t²)).
        for t in (-3.0, -0.5, 0.0, 1.0, 10.0):
            self.assertAlmostEqual(noncentral_t(t, 2, 0.0), 0.5 + t / (2.0 * math.sqrt(2.0 + t * t)), delta=1e-12)


class Compare(unittest.TestCase):
    def test_means_deviations_and_g_by_hand(self) -> None:
        # Means 2 and 4, deviations 1 and 1, so d = 2; ν = 4, so g = 2 (1 - 3/15).
        found = compare([1.0, 2.0, 3.0], [3.0, 4.0, 5.0])
        self.assertEqual((found.counts, found.means, found.deviations), ((3, 3), (2.0, 4.0), (1.0, 1.0)))
        self.assertAlmostEqual(found.g, 1.6, delta=1e-14)
        mirrored = compare([3.0, 4.0, 5.0], [1.0, 2.0, 3.0])
        self.assertAlmostEqual(mirrored.low, -found.high, delta=1e-9)

    def test_the_ends_of_the_interval_have_their_probabilities(self) -> None:
        found = compare([1.0, 2.0, 4.0, 4.5], [3.0, 4.0, 5.0, 9.0, 7.0], 0.9)
        freedom, root = 7, math.sqrt(4 * 5 / 9)
        unbiased = 1.0 - 3.0 / (4.0 * freedom - 1.0)
        t = found.g / unbiased * root
        self.assertAlmostEqual(noncentral_t(t, freedom, found.low / unbiased * root), 0.95, delta=1e-9)
        self.assertAlmostEqual(noncentral_t(t, freedom, found.high / unbiased * root), 0.05, delta=1e-9)

    def test_intervals_hold_the_truth_as_often_as_they_promise(self) -> None:
        # 100 pairs of groups one standard deviation apart. The number of intervals of 90 % that hold it is binomial: 90 ± 3, and four
        # deviations are 12. All 100 would be within that, so narrower ones are made too, of which half hold it: 50 ± 5. The interval is of the noncentrality; its factor 1 - 3/(4 ν - 1) is taken out again.
        chance = random.Random(1)
        unbiased = 1.0 - 3.0 / (4.0 * 13 - 1.0)
        for confidence, expected, deviation in [(0.9, 90, 3.0), (0.5, 50, 5.0)]:
            held = 0
            for _ in range(100):
                a = [chance.gauss(0.0, 1.0) for _ in range(6)]
                b = [chance.gauss(1.0, 1.0) for _ in range(9)]
                found = compare(a, b, confidence)
                held += found.low / unbiased <= 1.0 <= found.high / unbiased
            self.assertLessEqual(abs(held - expected), 4.0 * deviation, confidence)

    def test_what_cannot_be_compared_is_refused_in_words(self) -> None:
        for a, b, word in [
            ([1.0], [1.0, 2.0], "two values"),
            ([1.0, 1.0], [2.0, 2.0], "varies"),
            ([1.0, math.nan], [2.0, 3.0], "no number"),
        ]:
            with self.assertRaisesRegex(ValueError, word):
                compare(a, b)
        with self.assertRaisesRegex(ValueError, "confidence"):
            compare([1.0, 2.0], [2.0, 3.0], 1.0)


class LearningCurve(unittest.TestCase):
    def test_limits_by_the_formulas(self) -> None:
        # p0 = 5 %, p1 = 15 %: P = ln 3, Q = ln(19/17), both limits ln 9 / (P + Q).
        curve = cusum([True])
        both = math.log(3.0) + math.log(19.0 / 17.0)
        self.assertAlmostEqual(curve.values[0], -math.log(19.0 / 17.0) / both, delta=1e-15)
        self.assertAlmostEqual(curve.upper, math.log(9.0) / both, delta=1e-15)
        self.assertAlmostEqual(curve.lower, -curve.upper, delta=1e-15)

    def test_successes_alone_decide_with_the_twentieth(self) -> None:
        # ln 9 / ln(19/17) = 19.75 successes reach the limit.
        self.assertEqual(cusum([True] * 19).verdict, "undecided")
        self.assertEqual((cusum([True] * 25).decided, cusum([True] * 25).verdict), (19, "acceptable"))

    def test_failures_alone_decide_soon(self) -> None:
        # Each adds P/(P + Q), and ln 9 / ln 3 = 2 of them are the limit, up to rounding.
        curve = cusum([False] * 3)
        self.assertEqual(curve.verdict, "unacceptable")
        self.assertIn(curve.decided, (1, 2))

    def test_the_sum_is_a_likelihood_ratio(self) -> None:
        outcomes = [True, False, True, True, False, True]
        curve = cusum(outcomes, 0.1, 0.3)
        ratio = sum(math.log(0.7 / 0.9) if success else math.log(3.0) for success in outcomes)
        scale = math.log(3.0) + math.log(0.9 / 0.7)
        self.assertAlmostEqual(curve.values[-1], ratio / scale, delta=1e-12)

    def test_rates_out_of_order_are_refused(self) -> None:
        for rates in [(0.2, 0.1), (0.0, 0.1), (0.1, 1.0)]:
            with self.assertRaises(ValueError):
                cusum([True], *rates)
        with self.assertRaises(ValueError):
            cusum([True], alpha=0.5)


if __name__ == "__main__":
    unittest.main()
