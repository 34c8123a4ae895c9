// haptic-web as a whole: one source, one hub, one server, in one thread. Not RT.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "clients/web/gateway/web_options.h"

namespace hapticd::web {

class Gateway {
 public:
  /// Binds the address and opens the recording. Throws std::runtime_error with what is wrong and
  /// what to do. A daemon need not be there.
  explicit Gateway(WebOptions options);
  ~Gateway();
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;

  /// Serves until stop(), or a signal if stop_on_signals() was called.
  void run();
  /// Says goodbye to everyone and ends run(); from any thread.
  void stop();
  /// SIGINT and SIGTERM stop it.
  void stop_on_signals();

  /// Port bound.
  [[nodiscard]] std::uint16_t port() const;
  /// Token for control, or to steer the recording that is the source; empty: nobody may, since its
  /// key is a view key.
  [[nodiscard]] const std::string& token() const;
  /// What to open, for people: an address with the token for this machine, or by TLS for all.
  [[nodiscard]] std::string invitation() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace hapticd::web
