//! The camera: a long lens at three quarters from above, as near as the picture's margins allow.
//!
//! With the camera turned into its axes (right, up, back) a point at depth d = eye - z lies inside the margins
//! when |x - eye.x| <= t d, so the four extreme sums of x and t z over all points fix the eye exactly.

use glam::{Vec2, Vec3};

pub struct Camera {
    pub eye: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    /// Away from the scene; the view direction is its opposite.
    pub back: Vec3,
    /// Pixels for a tangent of one.
    focal: f32,
    /// Where the axis of the camera meets the picture.
    middle: Vec2,
}

/// What part of the picture the scene may fill, in pixels from the edges: left, right, top, bottom.
pub struct Margins(pub [f32; 4]);

impl Camera {
    /// Frames all points.
    pub fn new(
        points: impl Iterator<Item = Vec3> + Clone,
        width: f32,
        height: f32,
        margins: &Margins,
    ) -> Self {
        let back = Vec3::new(0.52, 0.47, 1.0).normalize();
        let right = Vec3::Y.cross(back).normalize();
        let up = back.cross(right);
        let [left_margin, right_margin, top_margin, bottom_margin] = margins.0;
        // Half the height of the picture is seen under atan(0.25), about 14 degrees.
        let focal = height / 2.0 / 0.25;
        let half = Vec2::new(width - left_margin - right_margin, height - top_margin - bottom_margin) / 2.0;
        let tangent = half / focal;

        let far = f32::NEG_INFINITY;
        let [mut most_right, mut most_left, mut most_up, mut most_down] = [far; 4];
        for p in points {
            let (x, y, z) = (p.dot(right), p.dot(up), p.dot(back));
            most_right = most_right.max(x + tangent.x * z);
            most_left = most_left.max(-x + tangent.x * z);
            most_up = most_up.max(y + tangent.y * z);
            most_down = most_down.max(-y + tangent.y * z);
        }
        let distance_x = (most_right + most_left) / (2.0 * tangent.x);
        let distance_y = (most_up + most_down) / (2.0 * tangent.y);
        // Even a single point is looked at from a distance of one radius.
        let distance = distance_x.max(distance_y).max(1.0);
        let eye =
            right * ((most_right - most_left) / 2.0) + up * ((most_up - most_down) / 2.0) + back * distance;
        let middle = Vec2::new(left_margin, top_margin) + half;
        Camera { eye, right, up, back, focal, middle }
    }

    /// Column and row in pixels, and the inverse of the depth.
    pub fn project(&self, p: Vec3) -> (Vec2, f32) {
        let from_eye = p - self.eye;
        let inverse_depth = -1.0 / from_eye.dot(self.back);
        let across = Vec2::new(from_eye.dot(self.right), -from_eye.dot(self.up));
        (self.middle + across * (self.focal * inverse_depth), inverse_depth)
    }

    /// The direction in which a place in the picture is seen; its part along `back` is -1.
    pub fn ray(&self, place: Vec2) -> Vec3 {
        let across = (place - self.middle) / self.focal;
        self.right * across.x - self.up * across.y - self.back
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scene_touches_its_margins() {
        let points =
            [[1.0, 0.2, 0.1], [-0.4, 0.9, 0.3], [0.1, -0.8, -0.6], [-0.5, -0.1, 0.9]].map(Vec3::from);
        let camera = Camera::new(points.into_iter(), 640.0, 480.0, &Margins([40.0, 60.0, 30.0, 50.0]));
        let places = points.map(|p| camera.project(p).0);
        let low = places.into_iter().reduce(Vec2::min).unwrap();
        let high = places.into_iter().reduce(Vec2::max).unwrap();
        assert!(low.x > 39.9 && low.y > 29.9 && high.x < 580.1 && high.y < 430.1, "{low} {high}");
        let fills_width = low.x < 40.1 && high.x > 579.9;
        let fills_height = low.y < 30.1 && high.y > 429.9;
        assert!(fills_width || fills_height, "{low} {high}");
    }

    #[test]
    fn rays_pass_through_what_they_show() {
        let point = Vec3::new(0.3, -0.2, 0.5);
        let camera = Camera::new([point, -point].into_iter(), 640.0, 480.0, &Margins([10.0; 4]));
        let (place, inverse_depth) = camera.project(point);
        assert!((camera.eye + camera.ray(place) / inverse_depth).distance(point) < 1e-5);
    }
}
