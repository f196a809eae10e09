#include <fmt/format.h>

#include <algorithm>

#include "config/formats/conversions.h"
#include "config/formats/number_text.h"
#include "config/formats/view_file_names.h"
#include "config/formats/writers.h"

namespace rigcal {
namespace {

constexpr double kFilmWidthMm = 36;  // FocalLength35mm belongs to a picture 36 mm wide

std::string XmpText(const Camera& camera, const Rigid3d& cam_from_world, int camera_group) {
  const double longer_side_px = std::max(camera.width_px, camera.height_px);
  const Eigen::Vector2d centre = PrincipalPointFromMiddlePx(camera) / longer_side_px;
  const char* model = !camera.HasDistortion()            ? "perspective"
                      : camera.p1 == 0 && camera.p2 == 0 ? "brown3"
                                                         : "brown3t2";
  // k1 k2 k3 k4 t1 t2, where t1 and t2 have Brown's own order: OpenCV's p2 and p1.
  const std::string distortion = NumbersText({camera.k1, camera.k2, camera.k3, 0, camera.p2, camera.p1});
  return fmt::format(
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
      "  <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
      "    <rdf:Description xmlns:xcr=\"http://www.capturingreality.com/ns/xcr/1.1#\" xcr:Version=\"3\"\n"
      "       xcr:PosePrior=\"exact\" xcr:Coordinates=\"absolute\" xcr:DistortionModel=\"{}\"\n"
      "       xcr:FocalLength35mm=\"{}\" xcr:Skew=\"0\" xcr:AspectRatio=\"1\"\n"
      "       xcr:PrincipalPointU=\"{}\" xcr:PrincipalPointV=\"{}\" xcr:CalibrationPrior=\"exact\"\n"
      "       xcr:CalibrationGroup=\"{}\" xcr:DistortionGroup=\"{}\" xcr:InTexturing=\"1\" xcr:InMeshing=\"1\">\n"
      "      <xcr:Rotation>{}</xcr:Rotation>\n"
      "      <xcr:Position>{}</xcr:Position>\n"
      "      <xcr:DistortionCoeficients>{}</xcr:DistortionCoeficients>\n"
      "    </rdf:Description>\n  </rdf:RDF>\n</x:xmpmeta>\n",
      model, NumberText(camera.fx_px * kFilmWidthMm / longer_side_px), NumberText(centre.x()), NumberText(centre.y()),
      camera_group, camera_group, NumbersText(RowByRow(cam_from_world.rotation.toRotationMatrix())),
      NumbersText(RowByRow(CentreInWorld(cam_from_world))), distortion);
}

}  // namespace

Result<ExportedFiles> RealityCaptureFiles(const RigCalibration& calibration) {
  const auto names = ViewFileNames(calibration, ".xmp");
  if (!names) return Fail(names.error());
  ExportedFiles files;
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    files[(*names)[v]] = XmpText(calibration.CameraOf(v), view.cam_from_world, view.camera);
  }
  return files;
}

}  // namespace rigcal
