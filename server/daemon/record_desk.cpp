// See record_desk.h.
#include "server/daemon/record_desk.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <string_view>
#include <utility>

#include "core/simulation/physics.h"
#include "proto/wire/request_result.h"
#include "proto/wire/whole_characters.h"
#include "server/confinement/landlock.h"
#include "server/scene_io/named_text.h"
#include "server/scene_io/sheet_translation.h"
#include "server/service/journal.h"

namespace hapticd {
namespace {

using wire::result_of;
using wire::whole_characters;

/// Of the path of a file in an answer, at most.
constexpr std::size_t kFileBytes = 4096;
/// Dumps written by themselves in one run, at most: a fault that comes again and again must not
/// fill the disk.
constexpr std::uint64_t kMaxFaultDumps = 20;

std::string name_of_now(const char* what) {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y%m%d-%H%M%S", &parts);
  return std::string(what) + "-" + text.data() + ".mcap";
}

/// The file that a peer means by `name`, which may lack the ending; empty: no file has that name.
std::string recording_of(std::string name) {
  constexpr std::string_view kEnding = ".mcap";
  if (name.ends_with(kEnding)) name.resize(name.size() - kEnding.size());
  return fault_of_name(name).empty() ? name + std::string(kEnding) : "";
}

/// What went wrong with `file`, without the folder it is in.
std::string without_folder(std::string error, const std::string& file) {
  if (error.starts_with(file)) {
    error.replace(0, file.size(), std::filesystem::path(file).filename().string());
  }
  return error;
}

/// `status` on the wire. Not everyone is told where the server keeps its files.
v1::RecordInfo record_info(const RecordStatus& status) {
  v1::RecordInfo info;
  info.set_state(status.recording        ? v1::RECORD_STATE_RECORDING
                 : !status.error.empty() ? v1::RECORD_STATE_FAILED
                 : !status.file.empty()  ? v1::RECORD_STATE_WRITTEN
                                         : v1::RECORD_STATE_IDLE);
  info.set_file(std::filesystem::path(status.file).filename().string());
  info.set_ticks(status.ticks);
  info.set_bytes(status.bytes);
  info.set_lost_ticks(status.lost_ticks);
  info.set_message(without_folder(status.error, status.file));
  return info;
}

std::string host_name() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

}  // namespace

v1::RecordHeader record_header(const DaemonPlan& plan) {
  v1::RecordHeader header;
  header.set_format_version(kRecordFormat);
  header.set_server_version(HAPTICD_VERSION);
  header.set_build(__VERSION__);
  header.set_host(host_name());
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  header.set_began_unix_s(std::chrono::duration<double>(now).count());
  *header.mutable_config() = plan.options.config;
  for (const ToolDevice& device : plan.player.devices) {
    v1::RecordedDevice& recorded = *header.add_devices();
    recorded.set_tool_id(device.tool_id);
    *recorded.mutable_profile() = to_profile(device.sheet);
  }
  header.set_period_ns(static_cast<std::uint64_t>(plan.player.period_ns));
  header.set_physics(kPhysics);
  return header;
}

StartError unstarted_recording(const std::string& fault) {
  return {kExitRecord, "--record: " + fault +
                           ". Give the name of a new file, in a folder you may write to, on a disk "
                           "with room."};
}

void RecordDesk::begin(const std::string& file) {
  if (recorder_ == nullptr || file.empty()) return;
  const std::string error = recorder_->start(file).get();
  file_ = file;
  if (error.empty()) return;
  throw unstarted_recording(error);
}

Answer RecordDesk::record(const RequestId& id, const v1::Record& record) {
  const bool recording = recorder_->will_record();
  const std::string name = recording_of(record.file());
  const auto path = [&name](const char* what) {
    return (recordings_folder() / (name.empty() ? name_of_now(what) : name)).string();
  };
  if (!record.file().empty() && name.empty()) {
    return result_of(v1::RESULT_CODE_INVALID, "record.file",
                     "Use a-z 0-9 _ - and at most 64 of them, with or without .mcap behind.");
  }
  if (record.mode() == v1::RECORD_MODE_START) {
    if (recording) {
      return result_of(v1::RESULT_CODE_BUSY, "record",
                       "A recording is already running. Stop it first.");
    }
    file_ = path("session");
    orders_.push_back({id, file_, recorder_->start(file_)});
  } else if (record.mode() == v1::RECORD_MODE_STOP) {
    if (!recording) {
      return result_of(v1::RESULT_CODE_WRONG_STATE, "record", "Nothing is being recorded.");
    }
    orders_.push_back({id, file_, recorder_->stop()});
  } else if (record.mode() == v1::RECORD_MODE_DUMP) {
    const std::string file = path("dump");
    orders_.push_back({id, file, recorder_->dump(file)});
  } else {
    return result_of(v1::RESULT_CODE_INVALID, "record.mode", "Say START, STOP or DUMP.");
  }
  return std::nullopt;
}

void RecordDesk::note(const LoopEvent& event, const v1::Item& item) {
  if (recorder_ == nullptr) return;
  v1::EventRecord record;
  record.set_tick(event.tick);
  *record.mutable_item() = item;
  recorder_->event(event.t_ns, std::move(record));
  const auto* fault = std::get_if<FaultNotice>(&event.what);
  if (fault == nullptr || !fault->latched || fault_dumps_ >= kMaxFaultDumps) return;
  ++fault_dumps_;
  recorder_->dump(recordings_folder() / name_of_now("fault"));
}

v1::RecordInfo RecordDesk::told() const { return record_info(told_); }

void RecordDesk::tell(const RecordStatus& status) {
  v1::Item item;
  *item.mutable_record_info() = record_info(status);
  clients_.tell(item);
}

void RecordDesk::answer(Order& order) {
  const std::string error = without_folder(order.error.get(), order.file);
  clients_.answer_with(order.id, [&] {
    if (!error.empty()) return result_of(v1::RESULT_CODE_FAILED, "record", error);
    v1::Result result = result_of(v1::RESULT_CODE_OK);
    const std::string file = std::filesystem::absolute(order.file).string();
    result.set_recorded(whole_characters(file, kFileBytes));
    return result;
  });
}

void RecordDesk::report() {
  if (recorder_ == nullptr) return;
  // What is done by now is told before it is answered.
  const auto done = std::find_if(orders_.begin(), orders_.end(), [](const Order& order) {
    return order.error.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
  });
  tell_changes();
  std::for_each(orders_.begin(), done, [this](Order& order) { answer(order); });
  orders_.erase(orders_.begin(), done);
}

void RecordDesk::tell_changes() {
  for (const DumpResult& dump : recorder_->take_dumps()) {
    RecordStatus status;
    status.file = dump.file;
    status.error = dump.error;
    if (dump.error.empty()) {
      log_entry(spdlog::level::info, "the last 60 s were written to " + dump.file,
                {{"HAPTICD_EVENT", "dump"}, {"HAPTICD_FILE", dump.file}});
    } else {
      spdlog::error("the last 60 s could not be written: {}", dump.error);
    }
    tell(status);
    // What goes on beside it is told last.
    if (told_.recording) tell(told_);
  }
  const RecordStatus status = recorder_->status();
  const bool same = status.recording == told_.recording && status.file == told_.file &&
                    status.error == told_.error;
  if (same) return;
  told_ = status;
  if (!status.error.empty()) {
    spdlog::error("recording: {}{}", status.error, reach_remedy(status.error));
  } else if (!status.file.empty()) {
    spdlog::info("{} {}", status.recording ? "records to" : "recorded to", status.file);
  }
  tell(status);
}

}  // namespace hapticd
