"""Medians, quartiles and quotients of measured costs. Every cost is better when it is smaller."""
import math


def quantile(values, share):
    """The value at this share of the sorted values, between neighbours by a straight line."""
    ordered = sorted(values)
    position = share * (len(ordered) - 1)
    below = math.floor(position)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (ordered[above] - ordered[below]) * (position - below)


def quartiles(values):
    """Median, first and third quartile."""
    return quantile(values, 0.5), quantile(values, 0.25), quantile(values, 0.75)


def gains(others, ours):
    """By pairs, how many times our cost the other is; above 1, ours is better. None where a cost is not positive: it has no quotient."""
    if any(cost <= 0 for cost in (*others, *ours)):
        return None
    return [other / our for other, our in zip(others, ours, strict=True)]


def geometric_mean(values):
    return math.exp(sum(map(math.log, values)) / len(values))
