"""Checks of section 6: what a State has, when it comes, and what makes the server send fewer."""
from peer import expect
from registry import check
from schema import control, item

ALL_BUT_TIMES = [number for number in control.Section.values() if number not in (0, control.SECTION_TIMING, control.SECTION_STAGES)]
OF_SECTION = {
    control.SECTION_TOOLS: "tools", control.SECTION_DEVICES: "devices", control.SECTION_STRINGS: "strings", control.SECTION_CONTACTS: "contacts",
    control.SECTION_TIMING: "timing", control.SECTION_ENERGY: "energy", control.SECTION_QUALITY: "quality",
    control.SECTION_STIFFNESS: "stiffness", control.SECTION_GESTURES: "gestures", control.SECTION_REPLAY: "replay",
}


def flowing(server, peer, count=5, **subscribe):
    """Subscribes, and returns the States that come from then on, as many as asked for."""
    peer.demand(item("subscribe", **subscribe))
    begin = len(peer.states)
    expect(peer.pump(5.0, lambda: len(peer.states) >= begin + count), f"{len(peer.states) - begin} States in 5 s after Subscribe {subscribe}")
    return [shown for _, shown in peer.states[begin:]]


def filled(shown):
    """The parts of a State that are there."""
    return {field.name for field, _ in shown.ListFields()} & set(OF_SECTION.values())


@check(6)
def states_come_at_multiples_of_the_divisor(server):
    """Subscribe asks for the States of the ticks that are multiples of divisor, in order, with t_ns in step."""
    holder = server.holder()
    server.ticking(holder)
    for divisor in (10, 7):
        shown = flowing(server, holder, 20, divisor=divisor)[1:]
        expect(all(each.tick % divisor == 0 for each in shown), f"ticks {[each.tick for each in shown]} at divisor {divisor}")
        for before, after in zip(shown, shown[1:]):
            expect(after.tick > before.tick, "ticks do not grow")
            period_ns = (after.t_ns - before.t_ns) / (after.tick - before.tick)
            expect(0.5 < period_ns * server.rate_hz / 1e9 < 2 or not server.virtual, f"{period_ns:.0f} ns from tick to tick")
        expect(all(each.scene_id >= 1 and 1 <= each.loop_state <= 7 for each in shown), "no scene_id or loop_state")


@check(6)
def sections_not_asked_for_are_not_filled_in(server):
    """A State has the sections asked for and no other; none named means tools, strings and contacts."""
    holder = server.holder()
    server.ticking(holder)
    for section, name in OF_SECTION.items():
        shown = flowing(server, holder, 3, divisor=10, sections=[section])[-2:]
        expect(all(filled(each) <= {name} for each in shown), f"section {name}: {filled(shown[-1])}")
        if name in ("tools", "devices", "timing", "energy", "quality", "stiffness"):
            expect(all(filled(each) == {name} for each in shown), f"section {name} is missing")
    shown = flowing(server, holder, 3, divisor=10)[-1]
    expect("tools" in filled(shown) and filled(shown) <= {"tools", "strings", "contacts"}, f"sections by default: {filled(shown)}")
    shown = flowing(server, holder, 3, divisor=10, sections=[control.SECTION_STAGES])[-1]
    expect(filled(shown) == {"timing"} and len(shown.timing.stages) > 0, "SECTION_STAGES brings no stages inside timing")


@check(6)
def every_tool_of_the_scene_is_shown_whole(server):
    """Each tool has its id, positions, unit quaternions and wrench; columns of a contact patch agree in length."""
    holder = server.holder()
    server.ticking(holder)
    shown = flowing(server, holder, 10, divisor=5, sections=[control.SECTION_TOOLS, control.SECTION_CONTACTS], max_contacts=256)[-5:]
    wanted = sorted(tool.tool_id for tool in server.scene.tools)
    for each in shown:
        if each.part_count > 1:
            continue
        expect(sorted(tool.tool_id for tool in each.tools) == wanted, f"tools {[tool.tool_id for tool in each.tools]}, not {wanted}")
        for tool in each.tools:
            lengths = [len(part) for part in (tool.p_wh_m, tool.q_wh, tool.p_wg_m, tool.q_wg, tool.wrench_h_w)]
            expect(lengths == [3, 4, 3, 4, 6], f"lengths {lengths}")
            for q in (tool.q_wh, tool.q_wg):
                expect(abs(sum(x * x for x in q) - 1) < 4e-6, f"a quaternion of norm {sum(x * x for x in q) ** 0.5}")
        for patch in each.contacts:
            n = len(patch.tool_sphere)
            lengths = [len(patch.p_wc_um), len(patch.nhat_og_w_e4), len(patch.gap_nanometres), len(patch.force_mn)]
            expect(lengths == [3 * n, 3 * n, n, n], f"a patch with columns of {lengths}")
            expect(list(patch.gap_nanometres) == sorted(patch.gap_nanometres), "contacts of a patch are not deepest first")


@check(6)
def the_newest_subscription_counts_and_0_ends_it(server):
    """A Subscribe replaces the one before it; divisor 0 ends it."""
    holder = server.holder()
    server.ticking(holder)
    flowing(server, holder, 5, divisor=3, sections=[control.SECTION_TOOLS])
    shown = flowing(server, holder, 8, divisor=11, sections=[control.SECTION_ENERGY])[1:]
    expect(all(each.tick % 11 == 0 and filled(each) == {"energy"} for each in shown), "the subscription before is still in force")
    holder.demand(item("subscribe", divisor=0))
    begin = len(holder.states)
    holder.pump(0.3)
    expect(len(holder.states) - begin <= 1, f"{len(holder.states) - begin} States after divisor 0")


@check(6)
def max_contacts_is_kept(server):
    """No more contacts are listed than max_contacts; contacts_total is there when some are left out, and only then."""
    holder = server.holder()
    server.ticking(holder)
    for most in (0, 1, 256):
        for each in flowing(server, holder, 10, divisor=5, sections=[control.SECTION_CONTACTS], max_contacts=most)[1:]:
            listed = sum(len(patch.tool_sphere) for patch in each.contacts)
            expect(listed <= most, f"{listed} contacts, {most} asked for")
            expect(not each.HasField("contacts_total") or each.contacts_total > listed, "contacts_total though all are listed")


@check(6)
def subscriptions_of_sessions_are_their_own(server):
    """Each session has its own divisor and sections."""
    holder = server.holder()
    server.ticking(holder)
    other = server.open()
    other.demand(item("subscribe", divisor=20, sections=[control.SECTION_QUALITY]))
    holder.demand(item("subscribe", divisor=50, sections=[control.SECTION_TOOLS]))
    for _ in range(20):
        other.pump(0.02)
        holder.pump(0.02)
    expect(other.states and holder.states, "no States")
    expect(all(each.tick % 20 == 0 and filled(each) == {"quality"} for _, each in other.states), "the other's States are not its own")
    expect(all(each.tick % 50 == 0 and filled(each) == {"tools"} for _, each in holder.states), "the holder's States are not its own")


@check(6)
def wrong_subscriptions_are_refused(server):
    """A divisor above 1e6 or more than 256 contacts is OUT_OF_RANGE."""
    peer = server.open()
    peer.demand(item("subscribe", divisor=1_000_001), "OUT_OF_RANGE")
    peer.demand(item("subscribe", divisor=1, max_contacts=257), "OUT_OF_RANGE")


@check(6, slow=True)
def loss_doubles_the_divisor(server):
    """When more than 10 % of a second's States were lost, the divisor doubles; once nothing is lost it comes back."""
    server.needs_realtime()
    peer = server.open()
    peer.demand(item("subscribe", divisor=10, sections=[control.SECTION_QUALITY]))
    peer.pump(1.0)
    peer.reports_states = False
    peer.pump(3.0)
    ticks = [each.tick for _, each in peer.states[-6:]]
    steps = {after - before for before, after in zip(ticks, ticks[1:])}
    expect(min(steps) >= 20, f"steps of {steps} ticks while all States are lost")
    peer.reports_states = True
    peer.pump(8.0)
    ticks = [each.tick for _, each in peer.states[-6:]]
    steps = {after - before for before, after in zip(ticks, ticks[1:])}
    expect(steps == {10}, f"steps of {steps} ticks after 8 s without loss")
