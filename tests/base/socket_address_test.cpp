#include "core/base/socket_address.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(SocketAddress, IsReadAndWritten) {
  for (const char* text : {"127.0.0.1:5100", "studio.local:1", "[::1]:65535", "localhost:0"}) {
    const auto address = ParseSocketAddress(text, 0);
    ASSERT_TRUE(address) << text;
    EXPECT_EQ(ToText(*address), text);
  }
  EXPECT_EQ(ParseSocketAddress("[fe80::1]:5100", 1)->host, "fe80::1");
  EXPECT_EQ(ParseSocketAddress("[fe80::1]:5100", 1)->port, 5100);
}

TEST(SocketAddress, RefusesWhatIsNone) {
  for (const char* text : {"", ":5100", "host", "host:", "host:0", "host:-1", "host:65536", "host:51x", "host: 51",
                           "::1:5100", "[]:5100", "[host]:5100", "poses.txt"}) {
    EXPECT_FALSE(ParseSocketAddress(text, 1)) << text;
  }
}

}  // namespace
}  // namespace rigcal
