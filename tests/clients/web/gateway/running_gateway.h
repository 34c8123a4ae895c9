// A Gateway in a thread of its own, on a port the system chose.
#pragma once

#include <thread>
#include <utility>

#include "clients/web/gateway/gateway.h"

namespace hapticd::test {

class RunningGateway {
 public:
  explicit RunningGateway(web::WebOptions options) : gateway_(local(std::move(options))) {
    thread_ = std::thread([this] { gateway_.run(); });
  }
  ~RunningGateway() {
    gateway_.stop();
    thread_.join();
  }
  RunningGateway(const RunningGateway&) = delete;
  RunningGateway& operator=(const RunningGateway&) = delete;

  [[nodiscard]] std::uint16_t port() const { return gateway_.port(); }
  /// Subprotocol of a page that may control.
  [[nodiscard]] std::string control() const { return "hapticd.v1." + gateway_.token(); }
  [[nodiscard]] const std::string& token() const { return gateway_.token(); }
  void stop() { gateway_.stop(); }

 private:
  static web::WebOptions local(web::WebOptions options) {
    options.server.port = 0;
    return options;
  }

  web::Gateway gateway_;
  std::thread thread_;
};

/// The options of a gateway for a daemon at `port` of loopback.
inline web::WebOptions options_for(std::uint16_t port) {
  web::WebOptions options;
  options.link.port = port;
  return options;
}

}  // namespace hapticd::test
