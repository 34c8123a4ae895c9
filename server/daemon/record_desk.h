// Recording of the session: who asked for what, and what everyone is told. Not RT.
#pragma once

#include <cstdint>
#include <future>
#include <string>
#include <vector>

#include "server/daemon/daemon_plan.h"
#include "server/daemon/served_clients.h"
#include "server/haptic_loop/loop_event.h"
#include "server/recorder/recorder_thread.h"

namespace hapticd {

/// What every recording of this run begins with.
[[nodiscard]] v1::RecordHeader record_header(const DaemonPlan& plan);

/// That the recording of --record cannot be begun.
[[nodiscard]] StartError unstarted_recording(const std::string& fault);

class RecordDesk {
 public:
  /// Both outlive this; `recorder` is null where a replay plays, which is not recorded.
  RecordDesk(RecorderThread* recorder, ServedClients& clients)
      : recorder_(recorder), clients_(clients) {}

  /// Begins what --record asks for, if anything: before the first tick, which a replay begins with.
  /// Throws StartError.
  void begin(const std::string& file);

  /// Answered once it is done, with the file.
  [[nodiscard]] Answer record(const RequestId& id, const v1::Record& record);
  /// `item` is what clients are told of `event`. A latched fault has the last 60 s written.
  void note(const LoopEvent& event, const v1::Item& item);
  /// Tells everyone what has changed, and of dumps that are written; answers what is done.
  void report();
  /// What clients were told last.
  [[nodiscard]] v1::RecordInfo told() const;

 private:
  /// Something that was asked for.
  struct Order {
    RequestId id;
    std::string file;
    std::future<std::string> error;
  };

  void tell_changes();
  void answer(Order& order);
  void tell(const RecordStatus& status);

  RecorderThread* recorder_;
  ServedClients& clients_;
  RecordStatus told_;
  std::string file_;           ///< of the session that was begun last
  std::vector<Order> orders_;  ///< not answered; the recorder carries them out in this order
  std::uint64_t fault_dumps_ = 0;
};

}  // namespace hapticd
