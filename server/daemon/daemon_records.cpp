// Recording: who asked for what, and what everyone is told. See daemon.h.
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <ctime>

#include "proto/wire/request_result.h"
#include "server/daemon/daemon.h"
#include "server/daemon/record_info.h"
#include "server/recorder/state_record.h"

namespace hapticd {
namespace {

using wire::result_of;

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

bool plain_name(const std::string& name) {
  return name.size() <= 64 &&
         name.find_first_not_of(
             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTU"
             "VWXYZ0123456789_-.") == std::string::npos &&
         name.find("..") == std::string::npos;
}

std::string host_name() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

}  // namespace

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
  info.set_message(status.error);
  return info;
}

v1::RecordHeader Daemon::record_header() const {
  v1::RecordHeader header;
  header.set_format_version(kRecordFormat);
  header.set_server_version(HAPTICD_VERSION);
  header.set_build(__VERSION__);
  header.set_host(host_name());
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  header.set_began_unix_s(std::chrono::duration<double>(now).count());
  *header.mutable_config() = options_.config;
  for (const ToolDevice& device : player_.devices) {
    v1::RecordedDevice& recorded = *header.add_devices();
    recorded.set_tool_id(device.tool_id);
    *recorded.mutable_profile() = device.profile.message;
  }
  header.set_period_ns(static_cast<std::uint64_t>(player_.period_ns));
  return header;
}

void Daemon::begin_recording() {
  if (!recording_ || options_.config.record().empty()) return;
  const std::string error = recording_->start(options_.config.record()).get();
  if (error.empty()) return;
  throw StartError(kExitRecord, "--record: " + error +
                                    ". Give the name of a new file, in a folder that may be "
                                    "written to and on a disk with room.");
}

void Daemon::take_back_recording() {
  if (!recording_ || options_.config.record().empty()) return;
  recording_.reset();
  std::error_code ignored;
  std::filesystem::remove(options_.config.record(), ignored);
}

void Daemon::announce_scene(const LiveScene& scene) {
  if (!recording_) return;
  v1::SceneRecord record;
  record.set_scene_id(scene.id);
  *record.mutable_scene() = scene.loaded->message;
  record.set_hash(scene.info.hash());
  *record.mutable_assets() = scene.info.assets();
  if (player_.max_force < kUnlimited) record.set_max_force_n(player_.max_force);
  recording_->announce(std::move(record));
}

// Before the loop hears of the change, whose number is the next.
void Daemon::announce_change(const SceneSettings& settings, const v1::SetParameter* set) {
  v1::ParameterRecord record;
  record.set_number(last_command_ + 1);
  if (set != nullptr) *record.mutable_assignments() = set->assignments();
  put_settings(settings, record);
  recording_->announce_change(std::move(record));
}

void Daemon::record(const RequestId& id, const v1::Record& record) {
  v1::Result result = result_of(v1::RESULT_CODE_OK);
  const RecordStatus status = recording_->status();
  if (!plain_name(record.file())) {
    result = result_of(v1::RESULT_CODE_INVALID, "record.file",
                       "Use a-z A-Z 0-9 _ - . and at most 64 of them.");
  } else if (record.mode() == v1::RECORD_MODE_START && status.recording) {
    result = result_of(v1::RESULT_CODE_BUSY, "record", "A recording runs already. Stop it first.");
  } else if (record.mode() == v1::RECORD_MODE_START) {
    const std::string name = record.file().empty() ? name_of_now("session") : record.file();
    recording_->start(recordings_folder() / name);
  } else if (record.mode() == v1::RECORD_MODE_STOP && !status.recording) {
    result = result_of(v1::RESULT_CODE_WRONG_STATE, "record", "Nothing is being recorded.");
  } else if (record.mode() == v1::RECORD_MODE_STOP) {
    recording_->stop();
  } else if (record.mode() == v1::RECORD_MODE_DUMP) {
    const std::string name = record.file().empty() ? name_of_now("dump") : record.file();
    recording_->dump(recordings_folder() / name);
  } else {
    result = result_of(v1::RESULT_CODE_INVALID, "record.mode", "Say START, STOP or DUMP.");
  }
  server_->answer(id, result);
}

void Daemon::record_event(const LoopEvent& event, const v1::Item& item) {
  if (!recording_) return;
  v1::EventRecord record;
  record.set_tick(event.tick);
  *record.mutable_item() = item;
  recording_->event(event.t_ns, std::move(record));
  const auto* fault = std::get_if<FaultNotice>(&event.what);
  if (fault == nullptr || !fault->latched || fault_dumps_ >= kMaxFaultDumps) return;
  ++fault_dumps_;
  recording_->dump(recordings_folder() / name_of_now("fault"));
}

void Daemon::report_recording() {
  const auto tell = [&](const v1::RecordInfo& info) {
    v1::Item item;
    *item.mutable_record_info() = info;
    server_->broadcast(item);
  };
  for (const DumpResult& dump : recording_->take_dumps()) {
    RecordStatus status;
    status.file = dump.file;
    status.error = dump.error;
    if (dump.error.empty()) {
      spdlog::info("the last 60 s were written to {}", dump.file);
    } else {
      spdlog::error("the last 60 s could not be written: {}", dump.error);
    }
    tell(record_info(status));
  }
  const RecordStatus status = recording_->status();
  const bool same = status.recording == told_record_.recording &&
                    status.file == told_record_.file && status.error == told_record_.error;
  if (same) return;
  told_record_ = status;
  if (!status.error.empty()) spdlog::error("recording: {}", status.error);
  tell(record_info(status));
}

}  // namespace hapticd
