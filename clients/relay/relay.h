// From a session with the daemon to the topics of an MQTT broker: what is published where, and what
// the broker keeps for later subscribers. clients/relay/README.md has the table. Pure. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "hapticd/v1/stream.pb.h"

namespace hapticd::relay {

/// A message for the broker.
struct Publication {
  std::string topic;
  std::string payload;
  bool retained = false;  ///< the broker gives it to later subscribers
  int qos = 0;            ///< 1: until the broker has it
};

/// The message of an Item below `prefix`; nothing for Items that are not for an audience.
[[nodiscard]] std::optional<Publication> publication_of(const std::string& prefix,
                                                        const v1::Item& item);
/// That of a State.
[[nodiscard]] Publication publication_of(const std::string& prefix, const v1::State& state);

/// What happened so far.
struct RelayCounters {
  std::uint64_t published = 0;
  std::uint64_t lost = 0;  ///< the broker was not there
};

class Relay {
 public:
  /// Hands a message to the broker; false: it is not there.
  using Publish = std::function<bool(const Publication&)>;

  Relay(std::string prefix, Publish publish)
      : prefix_(std::move(prefix)), publish_(std::move(publish)) {}

  void item(const v1::Item& item);
  void state(const v1::State& state);
  /// Whether the daemon is there: PREFIX/link, `live` or `gone`.
  void link(bool live);
  /// The broker is there, for the first time or again: gets what it has to keep.
  void connected();
  [[nodiscard]] const RelayCounters& counters() const noexcept { return counters_; }

 private:
  void publish(const Publication& publication);

  std::string prefix_;
  Publish publish_;
  std::map<std::string, Publication> kept_;  ///< by topic; the newest that is retained
  RelayCounters counters_;
};

/// What PREFIX/link says.
[[nodiscard]] Publication link_publication(const std::string& prefix, bool live);

}  // namespace hapticd::relay
