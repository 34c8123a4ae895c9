// Prints one hash per session of ticks. Equal output of two builds means equal bits of every
// wrench, pose, reading and event, whatever the compiler, its flags and the processor; deploy/test
// --full compares builds.
#include <cinttypes>
#include <cstdint>
#include <cstdio>

#include "tests/realtime/contact_session.h"
#include "tests/realtime/string_session.h"

namespace {

template <typename Session>
void print(const char* name, Session session, std::int64_t ticks) {
  session.run(ticks);
  std::printf("%s %016" PRIx64 "\n", name, session.hash());
}

}  // namespace

int main() {
  using hapticd::test::ContactSession;
  using hapticd::test::StringSession;
  print("hand", ContactSession(ContactSession::Tool::kHand), 10'000);
  print("blob", ContactSession(ContactSession::Tool::kBlob), 2'000);
  print("paper", StringSession(StringSession::Play::kPaper), 10'000);
  print("deflecting", StringSession(StringSession::Play::kDeflecting), 10'000);
  print("modes", StringSession(StringSession::Play::kModes), 10'000);
}
