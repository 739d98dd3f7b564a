//! The two papers, and the methods that the product is compared with.

mod accepted;
mod paper_formulas;
mod paper_local_compression;
mod paper_pictures;
mod paper_volume_preserved;
mod papers_table;
mod rivals_are_right;
mod scores_follow_the_paper;
mod stability_model;
