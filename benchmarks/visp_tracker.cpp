// ViSP's model-based tracker (moving edges, optionally with KLT points) on image files: one line a frame.
//
//     visp_tracker CONFIG.xml MODEL.cao edge|both TX TY TZ RX RY RZ IMAGE...
//
// Prints for each frame: tx ty tz (m) rx ry rz (rad), milliseconds of processor time, then the 36 numbers of
// ViSP's covariance. A frame in which it throws is a line `lost`, and so is each after it.
#include <cstdio>
#include <ctime>
#include <iostream>
#include <visp3/core/vpImage.h>
#include <visp3/io/vpImageIo.h>
#include <visp3/mbt/vpMbGenericTracker.h>

int main(int argc, char **argv)
{
  if (argc < 11) { std::cerr << "usage: see the head of visp_tracker.cpp\n"; return 2; }
  const bool both = std::string(argv[3]) == "both";
  vpMbGenericTracker tracker(1, both ? vpMbGenericTracker::EDGE_TRACKER | vpMbGenericTracker::KLT_TRACKER
                                     : vpMbGenericTracker::EDGE_TRACKER);
  std::cout.setstate(std::ios::failbit); // its parser prints what it reads
  tracker.loadConfigFile(argv[1]);
  tracker.setDisplayFeatures(false);
  tracker.setCovarianceComputation(true);
  vpImage<unsigned char> frame;
  vpImageIo::read(frame, argv[10]);
  tracker.loadModel(argv[2]);
  vpHomogeneousMatrix pose(atof(argv[4]), atof(argv[5]), atof(argv[6]), atof(argv[7]), atof(argv[8]), atof(argv[9]));
  tracker.initFromPose(frame, pose);
  bool lost = false;
  for (int k = 10; k < argc; k++) {
    vpImageIo::read(frame, argv[k]);
    const std::clock_t began = std::clock();
    try {
      if (!lost) tracker.track(frame);
    } catch (const vpException &) { lost = true; }
    const double ms = 1e3 * double(std::clock() - began) / CLOCKS_PER_SEC;
    if (lost) { std::printf("lost\n"); continue; }
    tracker.getPose(pose);
    const vpPoseVector v(pose);
    for (unsigned i = 0; i < 6; i++) std::printf("%.9g ", v[i]);
    std::printf("%.4f", ms);
    const vpMatrix spread = tracker.getCovarianceMatrix();
    for (unsigned i = 0; i < spread.getRows() * spread.getCols(); i++) std::printf(" %.6g", spread.data[i]);
    std::printf("\n");
  }
  return 0;
}
