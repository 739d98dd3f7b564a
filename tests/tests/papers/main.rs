//! The two papers, and the methods with which the product is compared.

mod accepted;
mod methods_are_right;
mod paper_formulas;
mod paper_local_compression;
mod paper_pictures;
mod paper_volume_preserved;
mod papers_table;
mod scores_follow_the_paper;
mod stability_model;
