#include <gmock/gmock.h>

#include "drivers/genicam/frame_stream.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

TEST(ReceivePath, WithoutAPacketSocketALargePictureNeedsALargeBuffer) {
  const GenicamOptions options{.packet_socket = false, .most_receive_buffer_bytes = 4'194'304};
  const ReceivePath path = ChooseReceivePath(12'000'000, options);
  EXPECT_FALSE(path.packet_socket);
  EXPECT_EQ(path.buffer_bytes, 4'194'304);
  EXPECT_THAT(path.warning, HasSubstr("sysctl -w net.core.rmem_max=15000000"));
  EXPECT_THAT(path.warning, HasSubstr("4194304"));
  EXPECT_THAT(path.warning, HasSubstr("CAP_NET_RAW"));
}

TEST(ReceivePath, ALargeBufferIsEnough) {
  const GenicamOptions options{.packet_socket = false, .most_receive_buffer_bytes = 67'108'864};
  const ReceivePath path = ChooseReceivePath(12'000'000, options);
  EXPECT_EQ(path.buffer_bytes, 15'000'000);
  EXPECT_EQ(path.warning, "");
}

TEST(ReceivePath, SmallPicturesFitIntoAnyBuffer) {
  const GenicamOptions options{.packet_socket = false, .most_receive_buffer_bytes = 212'992};
  EXPECT_EQ(ChooseReceivePath(76'800, options).warning, "");
}

}  // namespace
}  // namespace rigcal
