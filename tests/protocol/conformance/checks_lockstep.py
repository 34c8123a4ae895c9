"""Checks of section 11, which need a server with the virtual clock and a scripted device: steps, poses, hashes and the window of States."""
import hashlib
import time

from checks_state import ALL_BUT_TIMES
from peer import code, expect
from registry import check
from schema import control, item, state

STEP, STOP = control.RUN_MODE_STEP, control.RUN_MODE_STOP
AHEAD = 64
NOT_HASHED = ("timing", "scene_id", "contacts_total", "strings_total", "part_index", "part_count")


def run(holder, steps, seconds=60):
    """Advances and returns the RunResult."""
    return holder.demand(item("run", mode=STEP, steps=steps), seconds=seconds).run


def poses(server, count, first=0):
    """A path for tool 0 that comes down from 10 mm and goes up again."""
    tool = server.scene.tools[0].tool_id
    heights = [abs(count / 2 - tick) * 0.02 / count for tick in range(first, first + count)]
    return [{"tool_id": tool, "pose_dh": {"p_m": [0.0, height, 0.0], "q": [1, 0, 0, 0]}} for height in heights]


def play(server, holder, path):
    """Loads the scene anew, queues a path and runs it; returns the RunResult."""
    server.reload(holder)
    for start in range(0, len(path), 16):
        holder.queue(item("pose_batch", first_tick=start, poses=path[start:start + 16]))
    return run(holder, len(path))


@check(11)
def steps_advance_exactly(server):
    """Run{STEP, n} advances exactly n ticks; next_tick and 32 bytes of hash come back, and time stands still before and after."""
    server.needs_virtual()
    holder = server.holder()
    server.reload(holder)
    holder.demand(item("subscribe", divisor=1, sections=[control.SECTION_TOOLS]))
    holder.pump(0.2)
    expect(not any(each.tick > 0 for _, each in holder.states), "time runs by itself")
    total = 0
    for steps in (1, 2, 50):
        answer = run(holder, steps)
        total += steps
        expect((answer.steps, answer.next_tick, len(answer.state_hash)) == (steps, total, 32), f"{answer}")
    holder.pump(0.3, lambda: holder.states[-1][1].tick == total - 1)
    ticks = [each.tick for _, each in holder.states]
    expect(sorted(set(ticks)) == list(range(total)), f"ticks {sorted(set(ticks))[:60]}")
    last = holder.states[-1][1]
    expect(last.t_ns == round(last.tick * 1e9 / server.rate_hz), f"t_ns {last.t_ns} at tick {last.tick}")


@check(11)
def no_steps_are_out_of_range(server):
    """steps = 0 is OUT_OF_RANGE."""
    server.needs_virtual()
    server.holder().demand(item("run", mode=STEP), "OUT_OF_RANGE")


@check(11)
def poses_are_silent_when_good_and_counted_when_missing(server):
    """PoseBatch gets no Result when it is good; ticks without a sample hold the last pose and are counted in held_inputs."""
    server.needs_virtual()
    holder = server.holder()
    server.reload(holder)
    batch = holder.queue(item("pose_batch", first_tick=0, poses=poses(server, 10)))
    answer = run(holder, 30)
    expect(batch not in holder.results, f"a good PoseBatch was answered {holder.results.get(batch)}")
    expect(answer.held_inputs == 20, f"held_inputs {answer.held_inputs} after 10 samples and 30 ticks")


@check(11)
def poses_without_a_tick_follow_those_queued(server):
    """Without first_tick a batch begins right after the last sample queued."""
    server.needs_virtual()
    holder = server.holder()
    server.reload(holder)
    path = poses(server, 32)
    holder.queue(item("pose_batch", first_tick=0, poses=path[:16]))
    holder.queue(item("pose_batch", poses=path[16:]))
    answer = run(holder, 32)
    expect(answer.held_inputs == 0, f"held_inputs {answer.held_inputs}")


@check(11)
def queued_poses_go_with_their_scene(server):
    """Samples that are queued when a scene is exchanged go with the old one."""
    server.needs_virtual()
    holder = server.holder()
    server.reload(holder)
    holder.queue(item("pose_batch", first_tick=0, poses=poses(server, 16)))
    server.reload(holder)
    expect(run(holder, 16).held_inputs == 16, "the new scene got poses of the old one")


@check(11)
def the_haptic_tool_is_where_the_poses_say(server):
    """With the workspace map at its defaults p_WH of each tick is the position of its sample."""
    server.needs_virtual()
    holder = server.holder()
    tool = server.scene.tools[0]
    if tool.workspace.scale != 1 or any(tool.workspace.pose_wd.p_m) or tool.workspace.mirror > 1:
        return
    holder.demand(item("subscribe", divisor=1, sections=[control.SECTION_TOOLS]))
    path = poses(server, 40)
    holder.states.clear()
    play(server, holder, path)
    holder.pump(0.3)
    for _, each in holder.states:
        if each.scene_id == holder.of_kind("scene_info")[-1].scene_id:
            height = next(shown.p_wh_m[1] for shown in each.tools if shown.tool_id == tool.tool_id)
            expect(abs(height - path[each.tick]["pose_dh"]["p_m"][1]) < 1e-12, f"tick {each.tick}: p_WH {height}")


@check(11)
def the_same_poses_give_the_same_bits(server):
    """Scene and poses repeated give the same hash and the same States bit for bit; other poses give another hash."""
    server.needs_virtual()
    holder = server.holder()
    holder.demand(item("subscribe", divisor=1, sections=ALL_BUT_TIMES, max_contacts=256))
    path, seen, hashes = poses(server, 300), [], []
    for _ in range(2):
        holder.states.clear()
        hashes.append(play(server, holder, path).state_hash)
        holder.pump(0.3, lambda: holder.states and holder.states[-1][1].tick == 299)
        scene_id = holder.of_kind("scene_info")[-1].scene_id
        seen.append({each.tick: canonical(each) for _, each in holder.states if each.scene_id == scene_id})
    expect(hashes[0] == hashes[1], f"hashes {hashes[0].hex()} and {hashes[1].hex()}")
    common = seen[0].keys() & seen[1].keys()
    expect(len(common) >= 290, f"{len(common)} States of 300 arrived twice")
    different = [tick for tick in common if seen[0][tick] != seen[1][tick]]
    expect(not different, f"States of ticks {different[:5]} differ")
    path[150]["pose_dh"]["p_m"][2] = 1e-4
    expect(play(server, holder, path).state_hash != hashes[0], "another path gave the same hash")


def canonical(shown):
    """The bytes of section 11: encoded by protobuf in the order of the fields' numbers."""
    made = state.State()
    made.CopyFrom(shown)
    for field in NOT_HASHED:
        made.ClearField(field)
    for string in made.strings:
        string.ClearField("sounding")
    return made.SerializeToString()


@check(11)
def the_hash_is_that_of_the_states(server):
    """state_hash is the chain of BLAKE2b-256 over the canonical States as a client can compute it from what it received."""
    server.needs_virtual()
    holder = server.holder()
    holder.demand(item("subscribe", divisor=1, sections=ALL_BUT_TIMES, max_contacts=256))
    holder.states.clear()
    wanted = play(server, holder, poses(server, 100)).state_hash
    scene_id = holder.of_kind("scene_info")[-1].scene_id
    holder.pump(0.3, lambda: holder.states and holder.states[-1][1].tick == 99)
    shown = {each.tick: each for _, each in holder.states if each.scene_id == scene_id}
    expect(sorted(shown) == list(range(100)), f"{len(shown)} of 100 States arrived")
    if any(each.HasField("contacts_total") or each.HasField("strings_total") or each.part_count > 1 for each in shown.values()):
        return  # too large for one datagram: not all of it can be seen from here
    chain = bytes(32)
    for tick in range(100):
        chain = hashlib.blake2b(chain + canonical(shown[tick]), digest_size=32).digest()
    expect(chain == wanted, f"computed {chain.hex()}, told {wanted.hex()}")


@check(11)
def a_run_stays_64_states_ahead_at_most(server):
    """A Run waits when it is 64 States ahead of newest, repeats the newest State every 50 ms, and goes on when newest grows."""
    server.needs_virtual()
    holder = server.holder()
    server.reload(holder)
    holder.demand(item("subscribe", divisor=1, sections=[control.SECTION_TOOLS]))
    holder.states.clear()
    holder.newest, holder.reports_states = (0, 0), False
    number = holder.queue(item("run", mode=STEP, steps=1000))
    holder.send()
    holder.pump(0.6)
    highest = max(each.tick for _, each in holder.states)
    expect(highest <= AHEAD + 1, f"tick {highest} though newest is 0")
    expect(number not in holder.results, "the Run did not wait")
    repeats = [heard.at for heard, each in holder.states if each.tick == highest]
    expect(5 <= len(repeats) <= 20, f"the newest State came {len(repeats)} times in 600 ms of waiting")
    holder.reports_states = True
    result = holder.result(number, 30)
    expect(code(result) == "OK" and result.run.steps == 1000, f"{result}")


@check(11)
def the_lease_outlasts_a_run(server):
    """The lease does not expire during a Run of steps, however long the holder is silent."""
    server.needs_virtual()
    holder, watcher = server.holder(), server.open()
    server.reload(holder)
    holder.demand(item("subscribe", divisor=1, sections=[control.SECTION_TOOLS]))
    holder.newest, holder.reports_states = (0, 0), False
    number = holder.queue(item("run", mode=STEP, steps=200))
    holder.send()
    watcher.pump(2.6)
    expect(watcher.of_kind("lease_info")[-1].fence > 0, "the lease ended during a Run")
    holder.reports_states = True
    result = holder.result(number, 30)
    expect(code(result) == "OK" and result.run.steps == 200, f"{result}")


@check(8)
def stop_overtakes_a_run(server):
    """Run{STOP} and Stop overtake a Run of steps: it ends at the next tick, is answered first, and tells how far it came."""
    server.needs_virtual()
    holder = server.holder()
    for end in (item("run", mode=STOP), item("stop")):
        server.reload(holder)
        number = holder.queue(item("run", mode=STEP, steps=10**9))
        behind = holder.queue(item("ping"))
        holder.send()
        begin = time.monotonic()
        holder.pump(0.3)
        expect(number not in holder.results and behind not in holder.results, "a Run of 1e9 steps was over at once, or was overtaken by Ping")
        stopping = holder.queue(end)
        holder.send()
        holder.result(stopping, 5)
        holder.result(behind, 5)
        order = [each for each in holder.results if each in (number, behind, stopping)]
        expect(order[0] == number, f"Results in the order {order}; the Run is {number}, its end {stopping}")
        steps = holder.results[number].run.steps
        expect(0 < steps < 10**9, f"{steps} steps in {time.monotonic() - begin:.1f} s")
    holder.demand(item("clear"))
    run(holder, 1)  # Clear is obeyed by a tick
