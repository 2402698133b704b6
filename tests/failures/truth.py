"""What the servers have promised: each acknowledged batch with its revision, and what each answer said."""

import threading
import time

import numpy as np

from world import WRITERS, State, transforms


class Truth:
    """Threads: any."""

    def __init__(self, scene, nodes, first_revision):
        self.scene = scene
        self.nodes = nodes                      # (WRITERS, BOXES): ids
        self._first = first_revision
        self._lock = threading.Lock()
        self._batches = []                      # (writer, sequence, least, most): revisions between which it is
        self._newest = (first_revision, "")     # acknowledged: revision, token
        self._times = {}                        # of the acknowledgement of a revision
        self._answers = {}                      # (revision, rays, columns) -> how often
        self.stale = 0                          # answers from before the token that they were asked for
        self.stalest = 0.0                      # seconds that an answer without a token was behind

    def newest(self):
        """The newest acknowledged revision, and its token."""
        with self._lock:
            return self._newest

    def acknowledge(self, writer, sequence, least, most, token):
        """A batch is kept, in a revision from `least` to `most`."""
        with self._lock:
            self._batches.append((writer, sequence, least, most))
            self._times.setdefault(most, time.monotonic())
            if most > self._newest[0]:
                self._newest = (most, token)

    def answer(self, seed, hits, started, wanted):
        """An answer to the rays of `seed`, called for at `started` with the token of revision `wanted`, or 0."""
        key = (hits.revision, seed, hits.t.tobytes(), hits.node.tobytes())
        with self._lock:
            self._answers[key] = self._answers.get(key, 0) + 1
            if wanted:
                self.stale += hits.revision < wanted
            elif hits.revision < self._newest[0]:
                overtaken = min((at for revision, at in self._times.items() if revision > hits.revision), default=started)
                self.stalest = max(self.stalest, started - overtaken)

    # ---- afterwards

    def judge(self, rays, head, transforms_now):
        """rays: by seed. head: the revision at the end; transforms_now (WRITERS, BOXES, 3, 4): what the cluster then says."""
        order, faults = self._order(head)
        history = self._history(order, head)
        faults += [f"the boxes of writer {writer} are not where batch {sequence} has put them"
                   for writer, sequence in enumerate(history[head])
                   if not np.array_equal(transforms_now[writer], transforms(writer, sequence))]
        states, wrong, checked = {}, self.stale, 0
        for (revision, seed, t, node), count in self._answers.items():
            checked += count
            if revision not in states and revision in history:
                states[revision] = State(history[revision])
            hits = (np.frombuffer(t), np.frombuffer(node, np.uint64))
            if revision not in states or not states[revision].agrees(rays[seed], self.nodes.ravel(), hits):
                wrong += count
        return {"acknowledged": len(self._batches), "answers": checked, "lost": len(faults), "wrong": wrong,
                "stalest_s": self.stalest, "faults": faults}

    def _order(self, head):
        """Revision -> (writer, sequence), and what is wrong with it: each revision must be one batch, each batch one revision."""
        order, faults = {}, []
        for writer, sequence, least, most in self._batches:
            if least == most:
                if most in order:
                    faults.append(f"revision {most} was given to {order[most]} and {(writer, sequence)}")
                order[most] = (writer, sequence)
        # Of these the revision was not heard, as the call was lost: they fill the gaps, in their order.
        gaps = [revision for revision in range(self._first + 1, head + 1) if revision not in order]
        for writer, sequence, least, most in self._batches:
            if least < most:
                fitting = next((revision for revision in gaps if least <= revision <= most), None)
                if fitting is None:
                    faults.append(f"batch {(writer, sequence)} is in no revision from {least} to {most}")
                    continue
                gaps.remove(fitting)
                order[fitting] = (writer, sequence)
        faults += [f"revision {revision} is no acknowledged batch" for revision in gaps]
        faults += [f"batch {batch} at revision {revision} is after the head, {head}"
                   for revision, batch in order.items() if revision > head]
        return order, faults

    def _history(self, order, head):
        """Revision -> the newest batch of each writer in it."""
        newest = [0] * WRITERS
        history = {self._first: tuple(newest)}
        for revision in range(self._first + 1, head + 1):
            if revision in order:
                writer, sequence = order[revision]
                newest[writer] = sequence
            history[revision] = tuple(newest)
        return history
