// haptic-web: shows a running hapticd, or a recording, to browsers. Exit codes: 0 ended by a
// signal, 1 an address, key, certificate or recording is bad or it failed later, 2 the command line
// makes no sense. systemd hears by sd_notify(3) when it listens and when it ends.
#include <systemd/sd-daemon.h>

#include <cstdio>
#include <exception>

#include "clients/web/gateway/gateway.h"

int main(int argc, char** argv) {
  try {
    hapticd::web::ParsedOptions parsed = hapticd::web::parse_options(argc, argv);
    if (parsed.exit_code.has_value()) return *parsed.exit_code;
    hapticd::web::Gateway gateway(std::move(parsed.options));
    gateway.stop_on_signals();
    std::fputs(gateway.invitation().c_str(), stdout);
    std::fflush(stdout);
    static_cast<void>(sd_notify(0, "READY=1"));
    gateway.run();
    static_cast<void>(sd_notify(0, "STOPPING=1"));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic-web: %s\n", error.what());
    return 1;
  }
}
