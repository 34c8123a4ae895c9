// See request_table.h.
#include "server/daemon/request_table.h"

#include <algorithm>
#include <array>
#include <utility>

#include "proto/wire/choice_check.h"
#include "proto/wire/request_result.h"
#include "proto/wire/request_rule.h"
#include "server/daemon/scene_tool.h"

namespace hapticd {
namespace {

using wire::result_of;
using Id = const RequestId&;
using Item = const v1::Item&;

Answer listing(const std::vector<ListedName>& names) {
  v1::Result result = result_of(v1::RESULT_CODE_OK);
  v1::Listing& listing = *result.mutable_listing();
  for (const ListedName& each : names) {
    listing.add_names(each.name);
    listing.add_descriptions(each.description);
  }
  return result;
}

Answer stop(Desks& desks, Id id, Item /*item*/) {
  if (auto* time = std::get_if<VirtualTime>(&desks.time)) time->hurry();
  return desks.loop.command(id, StopCommand{});
}

Answer recentre(Desks& desks, Id id, Item item) {
  const std::uint32_t tool = tool_of(item.recentre().tool_id(), desks.scenes.newest().index);
  if (tool == kNoTool) return no_such_tool("recentre.tool_id");
  return desks.loop.command(id, RecentreCommand{tool});
}

Answer clutch(Desks& desks, Id id, Item item) {
  const std::uint32_t tool = tool_of(item.clutch().tool_id(), desks.scenes.newest().index);
  if (tool == kNoTool) return no_such_tool("clutch.tool_id");
  return desks.loop.command(id, ClutchCommand{tool, item.clutch().open()});
}

Answer run(Desks& desks, Id id, Item item) {
  if (item.run().mode() == v1::RUN_MODE_UNSPECIFIED) {
    return result_of(v1::RESULT_CODE_INVALID, "run.mode", "Say LIVE, STOP or STEP.");
  }
  auto* time = std::get_if<VirtualTime>(&desks.time);
  return time == nullptr ? RealTime::run(item.run()) : time->run(id, item.run());
}

Answer replay(Desks& desks, Id /*id*/, Item item) {
  auto* time = std::get_if<ReplayTime>(&desks.time);
  const bool end = item.replay().file().empty();
  if (end && time != nullptr) {
    time->ask_for_end();
    return result_of(v1::RESULT_CODE_OK);
  }
  const char* why =
      "Devices are playing. A replay needs its own daemon: hapticctl replay, or hapticd --device "
      "replay:FILE.";
  if (time != nullptr) {
    why = "Another recording is being replayed. End it first, with an empty name.";
  } else if (end) {
    why = "No replay runs.";
  }
  return result_of(v1::RESULT_CODE_WRONG_STATE, "replay.file", why);
}

Answer load_scene(Desks& desks, Id id, Item item) {
  BroughtFiles brought;
  if (Answer refused = desks.assets.find(item.load_scene(), brought)) return refused;
  return desks.scenes.load(id, item.load_scene(), std::move(brought));
}

template <typename Command>
Answer command(Desks& desks, Id id, Item /*item*/) {
  return desks.loop.command(id, Command{});
}

/// A kind of request.
struct Row {
  v1::Item::BodyCase kind;
  Answer (*carry_out)(Desks& desks, Id id, Item item);
};

constexpr std::array kRows{
    Row{v1::Item::kEngage, command<EngageCommand>},
    Row{v1::Item::kDisengage, command<DisengageCommand>},
    Row{v1::Item::kStop, stop},
    Row{v1::Item::kClear, command<ClearCommand>},
    Row{v1::Item::kRecentre, recentre},
    Row{v1::Item::kClutch, clutch},
    Row{v1::Item::kRun, run},
    Row{v1::Item::kReplay, replay},
    Row{v1::Item::kPoseBatch,
        [](Desks& desks, Id, Item item) { return desks.play.queue_poses(item.pose_batch()); }},
    Row{v1::Item::kPlayGesture,
        [](Desks& desks, Id id, Item item) {
          return desks.play.play_gesture(id, item.play_gesture());
        }},
    Row{v1::Item::kLoadScene, load_scene},
    Row{v1::Item::kPutAsset,
        [](Desks& desks, Id, Item item) { return desks.assets.put(item.put_asset()); }},
    Row{v1::Item::kGetParameters,
        [](Desks& desks, Id id, Item item) { return desks.scenes.parameters(id, item); }},
    Row{v1::Item::kSetParameter,
        [](Desks& desks, Id id, Item item) { return desks.scenes.parameters(id, item); }},
    Row{v1::Item::kRecord,
        [](Desks& desks, Id id, Item item) { return desks.records.record(id, item.record()); }},
    Row{v1::Item::kListScenes,
        [](Desks& desks, Id, Item) { return listing(desks.catalogues.scenes()); }},
    Row{v1::Item::kListGestures,
        [](Desks& desks, Id, Item) { return listing(desks.catalogues.gestures()); }},
    Row{v1::Item::kListRecordings,
        [](Desks& desks, Id, Item) { return listing(desks.catalogues.recordings()); }},
    Row{v1::Item::kGetDeviceInfo, [](Desks& desks, Id, Item) { return desks.devices.describe(); }},
    Row{v1::Item::kCalibrate,
        [](Desks& desks, Id id, Item item) {
          return desks.devices.calibrate(id, item.calibrate());
        }},
};

}  // namespace

Answer RequestTable::answer_to(const RequestId& id, const v1::Item& item) {
  const bool replays = std::holds_alternative<ReplayTime>(desks_.time);
  if (replays && wire::needs_control(item) && !item.has_replay()) {
    return result_of(v1::RESULT_CODE_WRONG_STATE, "",
                     "A recording is being replayed: nothing but what was recorded reaches it.");
  }
  // Nothing that has happened is still to be told: no thread but this one makes it happen.
  if (!std::holds_alternative<RealTime>(desks_.time)) desks_.loop.take_events();
  if (const std::optional<wire::UnknownChoice> unknown = wire::unknown_choice(item)) {
    return result_of(v1::RESULT_CODE_INVALID, unknown->path, unknown->message);
  }
  const auto row = std::find_if(kRows.begin(), kRows.end(),
                                [&](const Row& each) { return each.kind == item.body_case(); });
  if (row == kRows.end()) {
    return result_of(v1::RESULT_CODE_UNSUPPORTED, "",
                     "This version of hapticd does not know the request.");
  }
  return row->carry_out(desks_, id, item);
}

void RequestTable::carry_out(const RequestId& id, const v1::Item& item) {
  Answer answer;
  if (within_memory([&] { answer = answer_to(id, item); })) {
    if (answer) clients_.answer(id, std::move(*answer));
    return;
  }
  clients_.answer_with(id, [] { return wire::out_of_memory(); });
}

void RequestTable::abandon(const RequestId& id) {
  if (auto* time = std::get_if<VirtualTime>(&desks_.time)) time->abandon(id);
  desks_.scenes.abandon(id);
}

}  // namespace hapticd
