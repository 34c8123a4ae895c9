// Sends OSC messages over UDP, each in a bundle with its time. liblo behind it. Not RT.
#pragma once

#include <memory>
#include <string>

#include "clients/osc/osc_message.h"
#include "clients/osc/osc_time.h"

namespace hapticd::osc {

class OscSender {
 public:
  /// Throws std::runtime_error where there is no such address.
  OscSender(const std::string& host, std::uint16_t port);
  ~OscSender();
  OscSender(const OscSender&) = delete;
  OscSender& operator=(const OscSender&) = delete;

  /// False: the system did not take it.
  bool send(const OscMessage& message, const TimeTag& when);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace hapticd::osc
