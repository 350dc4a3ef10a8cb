// Arguments with a syntax of their own: lights, views, cameras, and numbers.
#pragma once

#include <map>
#include <shadowcut/io.hpp>
#include <string>
#include <utility>
#include <vector>

namespace shadowcut::cli {

// point:x,y,z, directional:dx,dy,dz or sun:dx,dy,dz, three finite numbers and nothing else.
Light parse_light(const std::string& spec);

// The argument of --light that gives this light.
std::string light_spec(const Light& light);

// plan, plan:HEIGHT, OBJECT:FACE or ex,ey,ez,tx,ty,tz[,fov in degrees].
io::View parse_view(const std::string& spec, const Scene& scene);

// --camera: ex,ey,ez,tx,ty,tz[,fov in degrees], in io::View.
io::View parse_camera(const std::string& spec);

// WIDTHxHEIGHT.
std::pair<int, int> parse_size(const std::string& spec);

// The shortest decimal that reads back as the same number.
std::string number_text(double value);
std::string number_text(float value);

// The kernels by their names, and the name of a kernel.
const std::map<std::string, Kernel>& kernels();
const char* kernel_name(Kernel kernel);

// As many finite numbers with commas between as `form` has names.
std::vector<double> parse_numbers_of(const std::string& option, const std::string& text,
                                     const std::string& form);

// A number from 0 to 1.
double parse_share(const std::string& option, const std::string& text);

// An area, or a solid angle with sr behind it.
MinFeature parse_min_feature(const std::string& text);

// x, y or z.
Vec3 parse_axis(const std::string& name);

}  // namespace shadowcut::cli
