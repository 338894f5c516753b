//! Compares photographs with closed forms and ray casts, and the device's photographs with the CPU's.

mod closed_form;
mod device;
mod ray_casts;
mod scenes;
mod shown;
