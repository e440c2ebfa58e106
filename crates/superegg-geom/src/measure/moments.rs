//! Volume and second moments, by Dirichlet's integrals.

use glam::DVec3;

use crate::superquadric::Superquadric;

impl Superquadric {
    /// The volume, for every pair of exponents. By Dirichlet's integral of Beta functions, with
    /// semi-axes a, b, c:
    ///
    /// ```text
    /// V = 8 a b c G(1 + e/2)^2 / G(1 + e) * G(1 + n/2) G(1 + n) / G(1 + 3n/2),   G = Gamma
    ///   = 2 a b c e n B(e/2, e/2 + 1) B(n/2, n + 1)
    /// ```
    ///
    /// (A. H. Barr, Superquadrics and angle-preserving transformations, 1981; A. Jaklic, A.
    /// Leonardis, F. Solina, Segmentation and recovery of superquadrics, 2000, section 2.4.)
    /// The relative error is below 1e-14 for exponents up to 8, and grows in proportion to them
    /// beyond. The limits are right: a box for exponents near 0, and 0 for exponents beyond 2,000,
    /// whose volume leaves the range of f64.
    ///
    /// ```
    /// use superegg_geom::{Exponents, Superquadric, glam::DVec3};
    /// let octahedron = Superquadric::unit(Exponents::new(2.0, 2.0)?);
    /// assert!((octahedron.volume() - 4.0 / 3.0).abs() < 1e-14);
    /// # Ok::<(), superegg_geom::ShapeError>(())
    /// ```
    pub fn volume(&self) -> f64 {
        let (e, n) = self.limited_exponents();
        let radii = self.radii();
        let section = ratio_of_gammas(&[e / 2.0, e / 2.0], &[e]);
        let profile = ratio_of_gammas(&[n / 2.0, n], &[1.5 * n]);
        8.0 * section * profile * radii.x * radii.y * radii.z
    }

    /// The second moments about the centre, the integrals of x^2, y^2 and z^2 over the shape. The
    /// mixed ones are 0: the axes are principal axes.
    ///
    /// ```text
    /// of x^2: (8/3) a^3 b c G(1 + e/2) G(1 + 3e/2) / G(1 + 2e) * G(1 + n/2) G(1 + 2n) / G(1 + 5n/2)
    /// of z^2: (8/3) a b c^3 G(1 + e/2)^2 / G(1 + e) * G(1 + 3n/2) G(1 + n) / G(1 + 5n/2)
    /// ```
    ///
    /// (Jaklic and others, as for [`Superquadric::volume`].) The error is that of the volume.
    ///
    /// ```
    /// use superegg_geom::{Superquadric, glam::DVec3};
    /// let expected = 4.0 * std::f64::consts::PI / 15.0;
    /// let moments = Superquadric::unit_sphere().second_moments();
    /// assert!((moments / expected - DVec3::ONE).length() < 1e-14);
    /// ```
    pub fn second_moments(&self) -> DVec3 {
        let (e, n) = self.limited_exponents();
        let radii = self.radii();
        let across = ratio_of_gammas(&[e / 2.0, 1.5 * e], &[2.0 * e])
            * ratio_of_gammas(&[n / 2.0, 2.0 * n], &[2.5 * n]);
        let along = ratio_of_gammas(&[e / 2.0, e / 2.0], &[e]) * ratio_of_gammas(&[1.5 * n, n], &[2.5 * n]);
        let product = 8.0 / 3.0 * radii.x * radii.y * radii.z;
        product * DVec3::new(across, across, along) * radii * radii
    }

    /// The principal moments of inertia about x, y and z through the centre, for density 1: of mass
    /// `m`, multiply by `m / volume`.
    ///
    /// ```text
    /// about x: the integral of y^2 + z^2, and so on
    /// ```
    ///
    /// ```
    /// use superegg_geom::Superquadric;
    /// let sphere = Superquadric::unit_sphere();
    /// let of_mass_one = sphere.inertia() / sphere.volume();
    /// assert!((of_mass_one.x - 0.4).abs() < 1e-14);
    /// ```
    pub fn inertia(&self) -> DVec3 {
        let moments = self.second_moments();
        DVec3::new(moments.y + moments.z, moments.x + moments.z, moments.x + moments.y)
    }

    /// Exponents as the Gamma function takes them: beyond 1e6 every ratio is 0 in f64.
    fn limited_exponents(&self) -> (f64, f64) {
        (self.exponents().e().min(1e6), self.exponents().n().min(1e6))
    }
}

/// The product of Gamma(1 + x) over `above`, divided by that over `below`.
fn ratio_of_gammas(above: &[f64], below: &[f64]) -> f64 {
    let logs = |xs: &[f64]| xs.iter().map(|x| libm::lgamma(1.0 + x)).sum::<f64>();
    (logs(above) - logs(below)).exp()
}
