#!/usr/bin/env python3
"""Laws of the planning model, on counts that are the same in every run. Skipped (77) without numpy."""
import dataclasses
import os
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
SYSTEM_PYTHON = "/usr/bin/python3"  # sees the distribution's numpy, which another one first in PATH does not
try:
    import numpy as np
except ImportError:
    if sys.executable != SYSTEM_PYTHON and os.path.exists(SYSTEM_PYTHON):
        os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, *sys.argv])
    print("skipped: there is no numpy")
    sys.exit(77)
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import residence
from agreement import WORKLOAD as SMALL
from choosing import Bounded, Hashing, RoundRobin
from costs import Costs, read_costs
from events import Simulation
from fanout import log_load
from fleet import POLICIES, Fleet
from processor import Processor
from ring import Ring
from spreading import spread
from steady import steady_state, waiting_factor
from sweep import smallest_fleets
from tree_cache import TreeCache
from workload import Workload, popularity, reach, scene_triangles

COSTS = Costs(**{**{field.name: 0.0 for field in dataclasses.fields(Costs)},
                 "client_request_s": 5e-4, "proxy_request_s": 1e-4, "server_request_s": 4e-4, "server_ray_s": 4e-7, "open_scene_s": 1e-3,
                 "open_triangle_s": 5e-8, "build_triangle_s": 5e-7, "piece_triangles": 400.0, "geometry_bytes": 20.0, "tree_bytes": 30.0,
                 "update_write_s": 3e-4, "update_follow_s": 1e-4, "commit_s": 5e-3, "database_commit_s": 3e-4, "database_update_s": 2e-4,
                 "database_notice_s": 1e-5, "database_read_s": 1e-4})
PLENTY = 1e6  # GiB
SCENES = np.arange(5_000)


class RingTest(unittest.TestCase):
    def test_losing_a_replica_moves_its_scenes_only(self):
        before, after = Ring(range(20)).owners(SCENES), Ring(r for r in range(20) if r != 7).owners(SCENES)
        self.assertTrue((after[before != 7] == before[before != 7]).all())
        self.assertNotIn(7, after)

    def test_a_new_replica_takes_scenes_and_moves_none_between_others(self):
        before, after = Ring(range(20)).owners(SCENES), Ring(range(21)).owners(SCENES)
        self.assertTrue((after[after != before] == 20).all())
        self.assertLess((after != before).mean(), 2 / 21)

    def test_preference_is_a_permutation_that_begins_with_the_owner(self):
        ring = Ring(range(12))
        for scene in range(50):
            order = list(ring.preference(scene))
            self.assertEqual(sorted(order), list(range(12)))
            self.assertEqual(order[0], ring.owners([scene])[0])

    def test_what_is_lost_goes_to_the_next_in_preference(self):
        full, less = Ring(range(12)), Ring(r for r in range(12) if r != 3)
        for scene in range(200):
            self.assertEqual(less.owners([scene])[0], next(r for r in full.preference(scene) if r != 3))


class ChoosingTest(unittest.TestCase):
    def test_round_robin_is_even(self):
        robin = RoundRobin(3)
        self.assertEqual([robin.choose(scene, [0] * 3) for scene in (5, 5, 5, 5)], [0, 1, 2, 0])

    def test_hashing_ignores_load(self):
        hashing = Hashing(5)
        self.assertEqual(hashing.choose(9, [0] * 5), hashing.choose(9, [100] * 5))

    def test_bounded_load_never_exceeds_its_bound(self):
        random, bounded, in_flight = np.random.default_rng(4), Bounded(7, 1.25), [0] * 7
        for _ in range(5_000):
            if sum(in_flight) and random.random() < 0.48:
                in_flight[random.choice([r for r in range(7) if in_flight[r]])] -= 1
                continue
            chosen = bounded.choose(int(random.zipf(1.5)) % 100, in_flight)
            in_flight[chosen] += 1
            self.assertLessEqual(in_flight[chosen], max(1, -(-np.ceil(1.25 * sum(in_flight)) // 7)))

    def test_bounded_is_hashing_while_there_is_room(self):
        bounded, hashing = Bounded(7, 1.25), Hashing(7)
        for scene in range(100):
            self.assertEqual(bounded.choose(scene, [0] * 7), hashing.choose(scene, [0] * 7))


class SpreadTest(unittest.TestCase):
    def test_all_requests_go_somewhere(self):
        shares = popularity(Workload(scenes=500))
        for policy in POLICIES:
            found = spread(shares, 30, policy, 1.25)
            by_scene = np.bincount(found.scene, found.share, 500) * found.alike
            np.testing.assert_allclose(by_scene, shares, atol=1e-12)

    def test_no_replica_has_more_than_the_bound(self):
        for bound in 1.0, 1.25, 2.0:
            found = spread(popularity(Workload(scenes=500)), 30, "bounded", bound)
            self.assertLessEqual(np.bincount(found.replica, found.share).max(), bound / 30 + 1e-12)


class ProcessorTest(unittest.TestCase):
    def test_a_job_alone_takes_its_time(self):
        processor = Processor(2)
        processor.add(1.0, 0.5, (1, "a"))
        self.assertEqual(processor.next_end(), 1.5)

    def test_four_jobs_on_two_cores_take_twice_as_long(self):
        processor = Processor(2)
        for number in range(4):
            processor.add(0.0, 1.0, (number, "a"))
        self.assertAlmostEqual(processor.next_end(), 2.0)
        for _ in range(4):
            processor.finish(2.0)
        self.assertAlmostEqual(processor.busy_s, 4.0)

    def test_a_short_job_overtakes_a_long_one(self):
        processor = Processor(1)
        processor.add(0.0, 1.0, (1, "long"))
        processor.add(0.0, 0.1, (2, "short"))
        end = processor.next_end()
        self.assertAlmostEqual(end, 0.2)
        self.assertEqual(processor.finish(end), (2, "short"))
        self.assertAlmostEqual(processor.next_end(), 1.1)


class TreeCacheTest(unittest.TestCase):
    def test_what_is_built_is_not_built_again(self):
        cache = TreeCache(1e12, 20, 30)
        built = sum(cache.visit(0, "a", 1_000, 0.3, 1e9).built for _ in range(200))
        self.assertAlmostEqual(built, 1_000)

    def test_the_least_recently_used_goes_first(self):
        cache = TreeCache(2.5 * 20 * 1_000, 20, 0)
        for scene in "a", "b", "a", "c":
            cache.visit(0, scene, 1_000, 0.1, 1e9)
        self.assertEqual([scene in cache for scene in "abc"], [True, False, True])
        self.assertEqual(cache.evictions, 1)
        self.assertAlmostEqual(cache.bytes, 2 * 20 * 1_000)

    def test_a_replaced_scene_begins_anew(self):
        cache = TreeCache(1e12, 20, 30)
        cache.visit(0, "a", 1_000, 0.5, 10)
        self.assertFalse(cache.visit(9, "a", 1_000, 0.5, 10).opened)
        visit = cache.visit(11, "a", 1_000, 0.5, 10)
        self.assertTrue(visit.opened)
        self.assertEqual(visit.missing, 1)

    def test_bytes_are_those_of_what_is_loaded(self):
        random, cache = np.random.default_rng(2), TreeCache(40_000, 20, 30)
        for step in range(2_000):
            cache.visit(step, int(random.integers(20)), 500, 0.2, float(random.exponential(300)))
            self.assertLessEqual(cache.bytes, 40_000)
        self.assertAlmostEqual(cache.bytes, sum(map(cache._bytes_of, cache._scenes.values())), places=4)


class EventsTest(unittest.TestCase):
    def test_arrivals_are_answered_queued_or_refused(self):
        for policy in POLICIES:
            simulation = Simulation(COSTS, dataclasses.replace(SMALL, clients=20_000), Fleet(replicas=3, policy=policy), queue_limit=50)
            tally = simulation.run_open(8_000)
            self.assertEqual(tally.arrived, 8_000)
            self.assertEqual(tally.arrived, tally.answered + tally.in_flight + tally.refused)
            self.assertGreater(tally.refused, 0)

    def test_a_closed_loop_answers_everything(self):
        tally = Simulation(COSTS, SMALL, Fleet(replicas=3), shared_cores=2).run_closed(6, 1_000)
        self.assertEqual((tally.arrived, tally.answered, tally.refused, tally.in_flight), (1_000, 1_000, 0, 0))
        self.assertLessEqual(tally.busy[0], 2 + 1e-9)

    def test_the_same_seed_gives_the_same_run(self):
        runs = [Simulation(COSTS, SMALL, Fleet(replicas=3, policy="bounded")).run_open(3_000) for _ in range(2)]
        np.testing.assert_array_equal(runs[0].responses_s, runs[1].responses_s)

    def test_one_replica_with_memory_becomes_warm(self):
        work = dataclasses.replace(SMALL, scenes=20, tree_life_s=1e9)
        tally = Simulation(COSTS, work, Fleet(replicas=1, memory_gib=PLENTY)).run_open(12_000, 10_000)
        self.assertGreater(tally.warm_share, 0.999)
        self.assertLessEqual(tally.built, scene_triangles(work).sum() + 1e-6)

    def test_hashing_builds_what_one_server_builds(self):
        work = dataclasses.replace(SMALL, scenes=20, tree_life_s=1e9)
        built = {policy: Simulation(COSTS, work, Fleet(replicas=replicas, policy=policy, memory_gib=PLENTY)).run_open(4_000).built
                 for policy, replicas in (("round_robin", 3), ("hashing", 3), ("bounded", 3))}
        one = Simulation(COSTS, work, Fleet(replicas=1, memory_gib=PLENTY)).run_open(4_000).built
        self.assertAlmostEqual(built["hashing"], one, delta=1e-6 * one)
        self.assertGreater(built["round_robin"], 2 * one)
        self.assertLess(built["bounded"], built["round_robin"])


class SteadyTest(unittest.TestCase):
    def test_one_replica_with_memory_is_warm(self):
        for policy in POLICIES:
            state = steady_state(COSTS, Workload(tree_life_s=1e12), Fleet(replicas=1, policy=policy, memory_gib=PLENTY))
            self.assertGreater(state.warm_share, 1 - 1e-5)

    def test_no_fleet_answers_more_than_its_replicas_alone(self):
        """With memory for everything. With little, hashing is ahead of that: each replica has its own scenes to keep."""
        work = Workload(clients=10_000_000, update_share=0, tree_life_s=1e12)
        one = steady_state(COSTS, work, Fleet(replicas=1, memory_gib=PLENTY)).answered
        for policy in POLICIES:
            for replicas in 2, 10, 100:
                state = steady_state(COSTS, work, Fleet(replicas=replicas, policy=policy, memory_gib=PLENTY))
                self.assertLessEqual(state.answered, replicas * one * (1 + 1e-6))
                self.assertLessEqual(state.answered, state.offered)

    def test_memory_is_kept_within_the_budget(self):
        for policy in POLICIES:
            state = steady_state(COSTS, Workload(), Fleet(replicas=3, policy=policy, memory_gib=2))
            self.assertLessEqual(state.memory_gib, 2 + 1e-6)

    def test_more_memory_is_never_colder(self):
        shares = [steady_state(COSTS, Workload(), Fleet(replicas=3, memory_gib=gib)).warm_share for gib in (1, 4, 16, 64, 256)]
        self.assertEqual(shares, sorted(shares))

    def test_hashing_is_never_colder_than_round_robin(self):
        for replicas in 1, 3, 30, 300:
            shares = {policy: steady_state(COSTS, Workload(), Fleet(replicas=replicas, policy=policy)).warm_share for policy in POLICIES}
            self.assertGreaterEqual(shares["hashing"], shares["round_robin"] - 1e-9)
            self.assertGreaterEqual(shares["bounded"], shares["round_robin"] - 1e-9)

    def test_agrees_with_events(self):
        for policy in "round_robin", "hashing":
            fleet = Fleet(replicas=3, policy=policy, memory_gib=0.2)
            tally = Simulation(COSTS, SMALL, fleet).run_open(12_000, 6_000)
            state = steady_state(COSTS, SMALL, fleet)
            self.assertAlmostEqual(tally.warm_share, state.warm_share, delta=0.05)
            self.assertAlmostEqual(tally.busy.mean() / fleet.cores / state.mean_load, 1, delta=0.1)

    def test_waiting_is_that_of_known_queues(self):
        self.assertAlmostEqual(waiting_factor(1, 0.5), 2)       # M/M/1: 1 / (1 - load)
        self.assertAlmostEqual(waiting_factor(2, 0.5), 4 / 3)   # M/M/2: 1 / (1 - load^2)
        self.assertAlmostEqual(waiting_factor(4, 0), 1)


class ResidenceTest(unittest.TestCase):
    def test_shares_are_those_of_a_drawn_stay(self):
        random, chance, near = np.random.default_rng(5), 0.9, 0.2
        missing = []
        for length in random.geometric(1 - chance, 20_000):
            missing.extend((1 - near) ** np.arange(length))
        self.assertAlmostEqual(np.mean(missing), residence.missing_share(chance, near), delta=0.01)
        self.assertAlmostEqual(1 - (1 - near) * np.mean(missing), residence.built_share(chance, near), delta=0.01)

    def test_a_scene_that_is_asked_for_often_stays(self):
        self.assertGreater(residence.stay(100.0, 10.0, 1e9), 1 - 1e-6)
        self.assertLess(residence.stay(0.001, 10.0, 1e9), 0.02)


class LogTest(unittest.TestCase):
    def test_every_notice_goes_to_all_replicas(self):
        few, many = (log_load(COSTS, 10.0, replicas, 0.0, 0.0) for replicas in (10, 20))
        notices = COSTS.database_notice_s * (many.transactions * 20 - few.transactions * 10)
        commits = COSTS.database_commit_s * (many.transactions - few.transactions)
        polls = COSTS.database_read_s * (many.reads - few.reads)
        self.assertAlmostEqual(many.cores - few.cores, notices + commits + polls)

    def test_updates_that_wait_together_are_one_transaction(self):
        self.assertLess(log_load(COSTS, 10_000.0, 3, 0.0, 0.0).transactions, 3 / COSTS.commit_s)

    def test_hashing_leaves_no_one_to_follow(self):
        work, size = Workload(clients=50_000, update_share=0.1), Fleet(replicas=50)
        reads = {policy: steady_state(COSTS, work, dataclasses.replace(size, policy=policy)).log_reads for policy in POLICIES}
        self.assertAlmostEqual(reads["hashing"], 4 * 50)
        self.assertLess(reads["bounded"], reads["round_robin"] / 5)


class WorkloadTest(unittest.TestCase):
    def test_popularity_is_zipfs(self):
        shares = popularity(Workload(scenes=100, zipf=1.2))
        self.assertAlmostEqual(shares.sum(), 1)
        self.assertAlmostEqual(shares[0] / shares[9], 10 ** 1.2)

    def test_reach_is_a_share_and_falls_where_rays_are_few(self):
        sizes = np.array([1e3, 1e4, 1e5, 1e6, 1e7])
        near = reach(Workload(), sizes, 400.0)
        self.assertTrue(((0 < near) & (near <= 1)).all())
        self.assertTrue((np.diff(near) <= 0).all())


class FilesTest(unittest.TestCase):
    def test_the_measured_costs_can_be_read(self):
        self.assertGreater(read_costs().warm_s(1_024, "hashing"), 0)

    def test_a_fleet_that_is_full_does_not_suffice(self):
        row = {"policy": "hashing", "zipf": 1, "clients": 10}
        found = smallest_fleets([{**row, "replicas": 5, "busiest": 0.5}, {**row, "replicas": 3, "busiest": 0.9}])
        self.assertEqual(found["hashing", 1, 10]["replicas"], 5)


if __name__ == "__main__":
    unittest.main()
