//! The studio's page and its two questions: fit this, render that. One thread answers,
//! others work.

use super::session::{FitRequest, SceneRequest, Session};
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{header, HeaderMap, StatusCode};
use axum::middleware::{from_fn_with_state, Next};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use chladni_frf::Result;
use serde_json::{json, Value};
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;

/// A question is a band or a scene: no more bytes than that needs.
const LARGEST_QUESTION: usize = 1 << 20;

/// Serves `session` until the process ends.
///
/// # Errors
/// A listener that stops working.
pub fn serve(
    session: Arc<Session>,
    listener: TcpListener,
    address: SocketAddr,
) -> std::io::Result<()> {
    let routes = Router::new()
        .route("/", get(page))
        .route("/api/fit", post(fit))
        .route("/api/scene", post(scene))
        .layer(DefaultBodyLimit::max(LARGEST_QUESTION))
        .layer(from_fn_with_state(address, only_from_here))
        .with_state(session);
    listener.set_nonblocking(true)?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_io()
        .build()?;
    runtime
        .block_on(async { axum::serve(tokio::net::TcpListener::from_std(listener)?, routes).await })
}

/// Refuses pages of other sites that reach this port by a name of their own, or post to
/// it from elsewhere.
async fn only_from_here(
    State(address): State<SocketAddr>,
    request: Request,
    next: Next,
) -> Response {
    match is_from_here(request.headers(), address) {
        true => next.run(request).await,
        false => (
            StatusCode::FORBIDDEN,
            "the studio answers its own page only\n",
        )
            .into_response(),
    }
}

fn is_from_here(headers: &HeaderMap, address: SocketAddr) -> bool {
    let here = [address.to_string(), format!("localhost:{}", address.port())];
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let host = text(header::HOST).is_some_and(|host| here.iter().any(|known| known == host));
    host && text(header::ORIGIN)
        .is_none_or(|origin| here.iter().any(|known| origin == format!("http://{known}")))
}

async fn page(State(session): State<Arc<Session>>) -> Html<String> {
    Html(chladni_report::studio_html(&session.title))
}

async fn fit(State(session): State<Arc<Session>>, Json(request): Json<FitRequest>) -> Json<Value> {
    at_work(move || session.fit(&request)).await
}

async fn scene(
    State(session): State<Arc<Session>>,
    Json(request): Json<SceneRequest>,
) -> Json<Value> {
    at_work(move || session.render(&request)).await
}

/// Runs `work` on a thread of its own; an error, and a bug too, is an answer in words.
async fn at_work(work: impl FnOnce() -> Result<Value> + Send + 'static) -> Json<Value> {
    Json(match tokio::task::spawn_blocking(work).await {
        Ok(Ok(value)) => value,
        Ok(Err(error)) => json!({ "error": error.to_string() }),
        Err(bug) => json!({ "error": format!("internal error: {bug}") }),
    })
}
