"""Cores that requests share evenly, as a replica's fair queue shares them: each gets a core while there are enough."""
import heapq


class Processor:
    """Times are seconds and may not go back. A job runs on one core at a time."""

    def __init__(self, cores):
        self._cores, self._jobs = cores, []
        self._now = self._progress = 0.0  # what a job that was always here would have got
        self.busy_s = 0.0                 # processor seconds spent

    def __len__(self):
        return len(self._jobs)

    def _speed(self):
        return min(1.0, self._cores / len(self._jobs)) if self._jobs else 0.0

    def advance(self, now):
        passed = now - self._now
        self.busy_s += passed * self._speed() * len(self._jobs)
        self._progress += passed * self._speed()
        self._now = now

    def add(self, now, seconds, job):
        """`job` needs so many processor seconds. Jobs are compared if they end together: give them a number first."""
        self.advance(now)
        heapq.heappush(self._jobs, (self._progress + seconds, job))

    def next_end(self):
        """When the first job ends if none comes; infinity if there is none."""
        if not self._jobs:
            return float("inf")
        return self._now + max(0.0, self._jobs[0][0] - self._progress) / self._speed()

    def finish(self, now):
        """Takes the job that ends now."""
        self.advance(now)
        return heapq.heappop(self._jobs)[1]
