// A page's Stop, by the daemon's Stop road: on a thread of its own, since the road is waited for;
// answered on the thread of the io_context. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "clients/library/client_core.h"
#include "clients/library/stop_road.h"

namespace boost::asio {
class io_context;  // NOLINT(readability-identifier-naming): Boost's name
}

namespace hapticd::web {

class StopErrand {
 public:
  /// `otherwise` is called on the thread of `context`, which outlives this, with what waits for an
  /// answer when the road was of no use.
  StopErrand(boost::asio::io_context& context, client::StopPlace place,
             std::function<void(client::ResultHandler)> otherwise);
  /// Waits for one under way.
  ~StopErrand();
  StopErrand(const StopErrand&) = delete;
  StopErrand& operator=(const StopErrand&) = delete;

  /// The daemon told the port of its road; 0: it has none.
  void look_at(std::uint16_t port);
  /// Stops; `done` hears it. What is asked for while one is under way is one Stop more, after it.
  void run(client::ResultHandler done);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace hapticd::web
