// The program in clients/library/README.md, line by line; client_test.cpp compares.
#include "tests/clients/library/example.h"

#include <iostream>

#include "clients/library/client.h"
#include "clients/library/controller.h"

int example(std::uint16_t port) {
  hapticd::client::ClientHandlers handlers;
  handlers.item = [](const hapticd::v1::Item& item) {
    if (item.has_tone()) std::cout << "a string sounds: " << item.tone().frequency_hz() << " Hz\n";
  };
  hapticd::client::Client client("127.0.0.1", port, handlers);
  if (!client.connect()) return 1;
  client.subscribe(10);
  hapticd::client::Controller controller(client);
  if (controller.acquire("example").code() != hapticd::v1::RESULT_CODE_OK) return 2;
  hapticd::v1::Pose pose;
  for (const double x : {0.0, 0.0, 0.0}) pose.add_p_m(x);
  for (const double q : {1.0, 0.0, 0.0, 0.0}) pose.add_q(q);
  for (int tick = 0; tick < 100; ++tick) controller.pose(0, pose);
  const hapticd::v1::Result result = controller.run(100);
  std::cout << result.run().steps() << " ticks\n";
  client.poll_until([&] { return client.state().has_value(); });
  return result.run().steps() == 100 ? 0 : 3;
}
