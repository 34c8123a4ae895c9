// Prints one hash per session of contact ticks. Equal output of two builds means equal bits of
// every wrench and pose, whatever the compiler, its flags and the processor; deploy/test --full
// compares builds.
#include <cinttypes>
#include <cstdio>

#include "tests/realtime/contact_session.h"

int main() {
  using hapticd::test::ContactSession;
  ContactSession hand(ContactSession::Tool::kHand);
  hand.run(10'000);
  std::printf("hand %016" PRIx64 "\n", hand.hash());
  ContactSession blob(ContactSession::Tool::kBlob);
  blob.run(2'000);
  std::printf("blob %016" PRIx64 "\n", blob.hash());
}
