// The rival of docs/perception.md: PCL's segmentation of a table scene (Trevor et al. 2013), timed.
//
// Integral-image normals, organized multi-plane segmentation, organized connected components of all that lies more than
// 1 cm above the largest level plane, clusters of more than 300 points. No features are measured.
//
// Reads frames from standard input, each: int32 width, height; float64 fx, fy, cx, cy; width * height float32 depth [m],
// 0 = none. Writes for each: float64 processor time [s], the best of `repeats` (first argument), and width * height int32
// labels, 0 = none.

#include <time.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <vector>

#include <pcl/features/integral_image_normal.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/euclidean_cluster_comparator.h>
#include <pcl/segmentation/organized_connected_component_segmentation.h>
#include <pcl/segmentation/organized_multi_plane_segmentation.h>

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;

static double processor_time() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

static std::vector<int32_t> segment(const Cloud::Ptr& cloud) {
  pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  pcl::IntegralImageNormalEstimation<Point, pcl::Normal> estimation;
  estimation.setNormalEstimationMethod(estimation.COVARIANCE_MATRIX);
  estimation.setMaxDepthChangeFactor(0.02f);
  estimation.setNormalSmoothingSize(10.0f);
  estimation.setInputCloud(cloud);
  estimation.compute(*normals);

  pcl::OrganizedMultiPlaneSegmentation<Point, pcl::Normal, pcl::Label> planes;
  planes.setMinInliers(1000);
  planes.setAngularThreshold(0.017453 * 3.0);
  planes.setDistanceThreshold(0.02);
  planes.setInputNormals(normals);
  planes.setInputCloud(cloud);
  using Region = pcl::PlanarRegion<Point>;
  std::vector<Region, Eigen::aligned_allocator<Region>> regions;
  std::vector<pcl::ModelCoefficients> models;
  std::vector<pcl::PointIndices> inliers, of_labels, of_boundaries;
  pcl::PointCloud<pcl::Label>::Ptr faces(new pcl::PointCloud<pcl::Label>);
  planes.segmentAndRefine(regions, models, inliers, faces, of_labels, of_boundaries);

  std::vector<int32_t> labels(cloud->size(), 0);
  size_t table = 0;
  for (size_t i = 1; i < inliers.size(); ++i) {
    if (inliers[i].indices.size() > inliers[table].indices.size()) table = i;
  }
  if (inliers.empty()) return labels;
  const auto& m = models[table].values;
  const float sign = m[3] < 0 ? -1.0f : 1.0f;  // the camera lies above the table

  // Label 1 is what is looked at: the comparator connects the labels of the set that it calls excluded, and no others.
  pcl::PointCloud<pcl::Label>::Ptr parts(new pcl::PointCloud<pcl::Label>(cloud->width, cloud->height));
  for (size_t i = 0; i < cloud->size(); ++i) {
    const Point& p = (*cloud)[i];
    const float height = sign * (m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3]);
    (*parts)[i].label = std::isfinite(p.z) && height > 0.01f ? 1 : 0;
  }
  using Comparator = pcl::EuclideanClusterComparator<Point, pcl::Label>;
  Comparator::Ptr comparator(new Comparator);
  Comparator::ExcludeLabelSetPtr looked_at(new Comparator::ExcludeLabelSet);
  looked_at->insert(1);
  comparator->setInputCloud(cloud);
  comparator->setLabels(parts);
  comparator->setExcludeLabels(looked_at);
  comparator->setDistanceThreshold(0.01f, false);
  pcl::PointCloud<pcl::Label> components;
  std::vector<pcl::PointIndices> clusters;
  pcl::OrganizedConnectedComponentSegmentation<Point, pcl::Label> connected(comparator);
  connected.setInputCloud(cloud);
  connected.segment(components, clusters);
  int32_t number = 0;
  for (const auto& cluster : clusters) {
    if (cluster.indices.size() <= 300 || (*parts)[cluster.indices[0]].label == 0) continue;
    ++number;
    for (const auto index : cluster.indices) labels[index] = number;
  }
  return labels;
}

int main(int count, char** arguments) {
  const int repeats = count > 1 ? std::atoi(arguments[1]) : 1;
  int32_t size[2];
  while (std::fread(size, sizeof(int32_t), 2, stdin) == 2) {
    double camera[4];
    const size_t pixels = static_cast<size_t>(size[0]) * size[1];
    std::vector<float> depth(pixels);
    if (std::fread(camera, sizeof(double), 4, stdin) != 4 || std::fread(depth.data(), sizeof(float), pixels, stdin) != pixels) {
      std::fprintf(stderr, "a frame on standard input is cut off\n");
      return 1;
    }
    // The cloud is made beforehand: a driver publishes it.
    Cloud::Ptr cloud(new Cloud(size[0], size[1]));
    cloud->is_dense = false;
    const float none = std::numeric_limits<float>::quiet_NaN();
    for (int v = 0; v < size[1]; ++v) {
      for (int u = 0; u < size[0]; ++u) {
        const float z = depth[static_cast<size_t>(v) * size[0] + u];
        Point& p = (*cloud)(u, v);
        p.x = z > 0 ? static_cast<float>((u - camera[2]) / camera[0]) * z : none;
        p.y = z > 0 ? static_cast<float>((v - camera[3]) / camera[1]) * z : none;
        p.z = z > 0 ? z : none;
      }
    }
    double best = 1e9;
    std::vector<int32_t> labels;
    for (int i = 0; i < repeats; ++i) {
      const double start = processor_time();
      labels = segment(cloud);
      best = std::min(best, processor_time() - start);
    }
    std::fwrite(&best, sizeof(double), 1, stdout);
    std::fwrite(labels.data(), sizeof(int32_t), pixels, stdout);
    std::fflush(stdout);
  }
  return 0;
}
