#include <fmt/format.h>

#include "config/formats/conversions.h"
#include "config/formats/marks.h"
#include "config/formats/number_text.h"
#include "config/formats/quoted_text.h"
#include "config/formats/writers.h"

namespace rigcal {
namespace {

std::string Element(const char* name, double number) {
  return fmt::format("          <{0}>{1}</{0}>\n", name, NumberText(number));
}

/// u = w / 2 + cx + x' (f + b1) + y' b2, v = h / 2 + cy + y' f, origin at the pixel's corner.
std::string SensorText(const Camera& camera, int id) {
  const Eigen::Vector2d centre = PrincipalPointFromMiddlePx(camera);
  const std::string resolution =
      fmt::format("<resolution width=\"{}\" height=\"{}\"/>\n", camera.width_px, camera.height_px);
  std::string text = fmt::format("      <sensor id=\"{}\" label=\"{}\" type=\"frame\">\n        {}", id,
                                 XmlQuoted(camera.id), resolution);
  text += "        <calibration type=\"frame\" class=\"adjusted\">\n          " + resolution;
  text += Element("f", camera.fy_px) + Element("cx", centre.x()) + Element("cy", centre.y());
  text += Element("b1", camera.fx_px - camera.fy_px) + Element("b2", camera.skew_px);
  text += Element("k1", camera.k1) + Element("k2", camera.k2) + Element("k3", camera.k3);
  // Metashape's P1 stands where OpenCV has p2.
  text += Element("p1", camera.p2) + Element("p2", camera.p1);
  return text + "        </calibration>\n      </sensor>\n";
}

}  // namespace

Result<ExportedFiles> MetashapeFiles(const RigCalibration& calibration) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- {} -->\n<document version=\"1.4.0\">\n"
      "  <chunk label=\"rigcal\" enabled=\"true\">\n    <sensors next_id=\"{}\">\n",
      ExportMark("metashape"), calibration.NumCameras());
  for (int c = 0; c < calibration.NumCameras(); ++c) text += SensorText(calibration.cameras[c], c);
  text += fmt::format("    </sensors>\n    <cameras next_id=\"{}\" next_group_id=\"0\">\n", calibration.NumViews());
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const View& view = calibration.views[v];
    text += fmt::format(
        "      <camera id=\"{}\" sensor_id=\"{}\" label=\"{}\" enabled=\"true\">\n        <transform>{}</transform>\n"
        "      </camera>\n",
        v, view.camera, XmlQuoted(view.name), NumbersText(RowByRow(MatrixOf(view.cam_from_world.Inverse()))));
  }
  text += "    </cameras>\n    <transform>\n      <rotation>1 0 0 0 1 0 0 0 1</rotation>\n";
  text += "      <translation>0 0 0</translation>\n      <scale>1</scale>\n    </transform>\n  </chunk>\n</document>\n";
  return ExportedFiles{{"cameras.xml", text}};
}

}  // namespace rigcal
