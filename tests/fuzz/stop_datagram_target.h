// What is fuzzed of the Stop road: datagrams to its judge, of peers with and without the key. Not
// RT.
#pragma once

#include <cstdint>
#include <span>

namespace hapticd::test {

/// `bytes`: the first says by bit 0 that the daemon has a key. Then a row of datagrams, each after
/// two bytes. The first: bits 0 and 1: who sends it, 0 and 1 from this machine; bit 2: it gets the
/// daemon's tag; bit 3: the challenge that its sender was given last; bit 4: 100 ms pass before it;
/// bit 5: 2 s more; bit 6: the loop ticks before it; bit 7: and hears a Clear, or, without bit 6,
/// the datagram is lost and only overheard. The second: its length, or, with bit 7, that one comes
/// again which has been sent, by whoever. Nothing latches and nothing holds the force off but by
/// this machine or by the key with a challenge that is new; no answer is longer than its question,
/// nor goes to a stranger. Throws std::logic_error where that does not hold. True when some
/// datagram was obeyed.
bool check_stop_datagrams(std::span<const std::uint8_t> bytes);

}  // namespace hapticd::test
