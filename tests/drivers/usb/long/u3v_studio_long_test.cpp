// USB3 Vision at 12 megapixels (issue 4, point 4): every picture identical, an unplugged camera reported within a
// second, and a recording by the unmodified program resumed after plugging in again.

#include <gmock/gmock.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <thread>

#include "sim_fixtures/grbl/grbl_simulator.h"
#include "tests/drivers/usb/camera/u3v_peer.h"
#include "tests/drivers/usb/emulated/emulated_usb.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kWidth_px = 4000, kHeight_px = 3000;
constexpr double kHang_s = 300;
constexpr double kReported_s = 1;               ///< from the pull to the Error
constexpr std::size_t kMiddle_bytes = 4 << 20;  ///< of a picture's 12 MB
constexpr int kNumStops = 12;

const sim::U3vCameraSpec kLarge = {.serial = "U3V12", .width_px = kWidth_px, .height_px = kHeight_px};

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && std::memcmp(a.ptr(), b.ptr(), a.total() * a.elemSize()) == 0;
}

void Stall(sim::U3vCamera& camera, bool on) {
  sim::U3vFaults faults;
  if (on) faults.stalls_after_bytes = kMiddle_bytes;
  camera.Set(faults);
}

TEST(U3vStudio, TwelveMegapixelsComeIdenticalAndAPulledPlugIsReportedWithinASecond) {
  const std::unique_ptr<U3vPeer> peer = U3vPeer::Start(kLarge);
  ASSERT_TRUE(peer);
  auto camera = peer->Open();
  ASSERT_TRUE(camera) << camera.error().message;
  constexpr int kNumPictures = 20;
  double taking_s = 0;
  const auto take = [&](int shot) {
    const cv::Mat expected = peer->Expected(shot);
    peer->Arrange(shot);
    const double begin_s = peer->Time().NowS();
    ASSERT_TRUE((*camera)->MakeReady({}));
    ASSERT_TRUE((*camera)->Fire());
    const Result<CapturedPicture> picture = (*camera)->Collect(kHang_s, {});
    taking_s += peer->Time().NowS() - begin_s;
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_TRUE(Same(picture->pixels, expected)) << shot;
  };
  for (int shot = 0; shot < kNumPictures; ++shot) take(shot);
  std::printf("%d pictures of 12 megapixels, %.3f s each\n", kNumPictures, taking_s / kNumPictures);

  Stall(peer->Camera(), true);
  ASSERT_TRUE((*camera)->MakeReady({}));
  ASSERT_TRUE((*camera)->Fire());
  double pulled_s = 0;
  std::jthread puller([&] {
    EXPECT_TRUE(peer->Camera().AwaitStalled(kHang_s));
    pulled_s = peer->Time().NowS();
    peer->Unplug();
  });
  const Result<CapturedPicture> lost = (*camera)->Collect(kHang_s, {});
  const double reported_s = peer->Time().NowS();
  puller.join();
  ASSERT_FALSE(lost);
  std::printf("unplugged in the middle: reported after %.3f s: %s\n", reported_s - pulled_s,
              lost.error().message.c_str());
  EXPECT_LT(reported_s - pulled_s, kReported_s);

  Stall(peer->Camera(), false);
  peer->PlugIn();
  const Result<void> restored = (*camera)->Restore(kHang_s, {});
  ASSERT_TRUE(restored) << restored.error().message;
  take(kNumPictures);
}

/// A turntable and a camera, taken by the program itself. Each exposure shows a pattern of its own.
class U3vRecording : public WithEmulatedUsb {
 protected:
  void SetUp() override {
    WithEmulatedUsb::SetUp();
    if (usb_ == nullptr) return;
    ASSERT_TRUE(fs::exists(RIGCAL_BINARY)) << RIGCAL_BINARY << " is not built";
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    table_ = *sim::GrblSimulator::Start(clock_);
    camera_ = std::make_shared<sim::U3vCamera>(kLarge, [this](const sim::U3vShot& shot) {
      return U3vPeer::Pattern(num_shown_++, shot.width_px, shot.height_px);
    });
    std::ofstream(folder_ / "rig.toml") << fmt::format(
        "[positioner]\nkind = \"turntable\"\ndriver = \"grbl\"\naddress = \"{}\"\nsettle_s = 0.1\n[stops]\ncount = {}\n"
        "[[camera]]\nid = \"top\"\ndriver = \"genicam\"\nserial = \"{}\"\nexposure_us = 5000\n",
        table_->Path(), kNumStops, kLarge.serial);
  }
  void TearDown() override {
    WithEmulatedUsb::TearDown();
    fs::remove_all(folder_);
  }
  Result<void> PlugIn() { return usb_->Plug(PlugOf(kLarge), camera_); }
  /// Runs `rigcal capture`; its exit status, and what it said in said_.
  int Capture(const std::string& words) {
    const std::string log = (folder_ / "said").string();
    const int status = std::system(fmt::format("{} capture --rig {} --out {} --run-dir {} {} > {} 2>&1", RIGCAL_BINARY,
                                               (folder_ / "rig.toml").string(), (folder_ / "taken").string(),
                                               (folder_ / "run").string(), words, log)
                                       .c_str());
    std::ifstream file(log);
    said_.assign(std::istreambuf_iterator<char>(file), {});
    return status;
  }
  /// How many pictures there are, each one that was shown, and none twice.
  int NumPictures() {
    std::vector<cv::Mat> shown;
    for (int i = 0; i < num_shown_; ++i) shown.push_back(U3vPeer::Pattern(i, kWidth_px, kHeight_px));
    std::set<std::size_t> seen;
    int count = 0;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_ / "taken")) {
      if (entry.path().extension() != ".png") continue;
      ++count;
      const cv::Mat picture = cv::imread(entry.path().string(), cv::IMREAD_UNCHANGED);
      const auto found = std::ranges::find_if(shown, [&](const cv::Mat& each) { return Same(picture, each); });
      EXPECT_NE(found, shown.end()) << entry.path() << " was never shown";
      EXPECT_TRUE(seen.insert(static_cast<std::size_t>(found - shown.begin())).second) << entry.path();
    }
    return count;
  }

  SystemClock clock_;
  fs::path folder_ = fs::temp_directory_path() / "rigcal-u3v-studio";
  std::unique_ptr<sim::GrblSimulator> table_;
  std::shared_ptr<sim::U3vCamera> camera_;
  int num_shown_ = 0;
  std::string said_;
};

TEST_F(U3vRecording, IsResumedAfterTheCameraWasUnpluggedInTheMiddleOfIt) {
  ASSERT_TRUE(PlugIn());
  std::future<int> first = std::async(std::launch::async, [this] { return Capture(""); });
  ASSERT_TRUE(camera_->AwaitShots(kNumStops / 2, kHang_s));
  Stall(*camera_, true);
  ASSERT_TRUE(camera_->AwaitStalled(kHang_s));
  usb_->UnplugAll();
  EXPECT_NE(first.get(), 0);
  std::printf("unplugged: %s", said_.c_str());
  EXPECT_THAT(said_, HasSubstr("camera 'top'"));
  const int num_before = NumPictures();
  EXPECT_GE(num_before, 1);
  EXPECT_LT(num_before, kNumStops);

  Stall(*camera_, false);
  ASSERT_TRUE(PlugIn());
  EXPECT_EQ(Capture("--resume"), 0) << said_;
  std::printf("plugged in again: %s", said_.c_str());
  EXPECT_EQ(NumPictures(), kNumStops);
}

TEST_F(U3vRecording, IsRefusedWithMalformedDescriptors) {
  sim::UsbPlug plug = PlugOf(kLarge);
  plug.descriptors[35] = 3;  // Aravis crashes on it
  ASSERT_TRUE(usb_->Plug(plug, camera_));
  const int status = Capture("");
  std::printf("malformed: %s", said_.c_str());
  EXPECT_TRUE(WIFEXITED(status)) << "it crashed";
  EXPECT_NE(status, 0);
  EXPECT_THAT(said_, HasSubstr("malformed descriptors (offset 35"));
}

}  // namespace
}  // namespace rigcal
