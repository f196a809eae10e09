#pragma once

#include <opencv2/core.hpp>

namespace rigcal {

/// How much fine detail a picture has for its coarse contrast: root mean square of the band between 1 and 2 pixels
/// (Gaussian sigmas) over that between 4 and 8, over the pixels of the object alone. Blind to exposure and contrast;
/// falls as soon as blur takes the fine band away. Only pictures of the same object at the same scale compare. `mask`:
/// 255 = object, same size; empty: the whole picture. 0 when there is nothing to tell it from: no object, no contrast.
double Sharpness(const cv::Mat1f& gray, const cv::Mat1b& mask);

}  // namespace rigcal
