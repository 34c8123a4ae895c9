// How many connections there may be, in all and from where: whoever waits gives way to the next,
// and nobody from elsewhere takes the places of this machine, where the player's page is. Pure. Not
// RT.
#pragma once

#include <boost/asio/ip/address.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>

#include "clients/web/gateway/wait_list.h"

namespace hapticd::web {

struct DoorLimits {
  std::size_t connections = 256;  ///< a quarter of them are for this machine alone
  std::size_t of_address = 16;    ///< of one address that is not this machine's; of IPv6, one /64
};

/// What happened so far.
struct DoorCounters {
  std::uint64_t refused_full = 0;     ///< no place, and nobody who waits
  std::uint64_t refused_address = 0;  ///< as many of one address, and none of them waits
  std::uint64_t evicted = 0;          ///< gave way to another
};

class Door {
 public:
  explicit Door(const DoorLimits& limits) noexcept : limits_(limits) {}

  /// One more comes, and has a place until leave(); false: there is none. Of those that wait the
  /// one that has waited longest may have to go: of the same address where that has enough, of
  /// those from elsewhere otherwise, and of this machine only for another one of this machine.
  /// `now_ns` is of a clock that never goes back.
  bool enter(const boost::asio::ip::address& from, std::int64_t now_ns);
  /// One of that address, that has a place, goes.
  void leave(const boost::asio::ip::address& from);

  /// It waits for its peer, and from here on may have to give way: `give_way` is called, once,
  /// its place is free then. Its number, for resume().
  std::uint64_t wait(const boost::asio::ip::address& from, std::int64_t now_ns,
                     std::function<void()> give_way);
  /// It does not wait any more; 0 and what has given way are nobody.
  void resume(std::uint64_t number) { waiting_.remove(number); }

  /// Connections that have a place.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Of them, those that wait.
  [[nodiscard]] std::size_t waiting() const noexcept { return waiting_.size(); }
  [[nodiscard]] const DoorCounters& counters() const noexcept { return counters_; }

 private:
  bool make_place(const std::function<bool(const boost::asio::ip::address&)>& of,
                  std::int64_t now_ns);

  DoorLimits limits_;
  DoorCounters counters_;
  std::size_t size_ = 0;
  std::size_t from_elsewhere_ = 0;
  std::map<boost::asio::ip::address, std::size_t> held_;
  WaitList waiting_;
};

}  // namespace hapticd::web
